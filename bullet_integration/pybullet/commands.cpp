#include "commands.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

#include "body_ids.hpp"
#include "bytes.hpp"
#include "contact_answers.hpp"
#include "questions.hpp"
#include "report.hpp"
#include "settings.hpp"

namespace softcd::bullet::pybullet {
namespace {

/// A command that is being executed.
struct Call {
  Session& session;
  PhysicsCommandProcessorInterface& server;
  std::istringstream& words;  ///< behind the command's name
  std::string_view input;

  Attachment& attachment() const {
    Attachment* const attachment = session.attachment();
    if (attachment == nullptr)
      throw Error("softcd is not attached: the world was reset, or softcd was detached; attach it again.");
    return *attachment;
  }
  WorldDetection& detection() const { return attachment().detection(); }
  btDynamicsWorld& world() const { return session.world(server); }
  WorldProbe& probe() const { return session.probe(server); }

  template <class Value>
  Value read(const char* name) const {
    Value value{};
    if (!(words >> value)) throw InvalidInput(fmt::format("{}: expected a number.", name));
    return value;
  }
  btSoftBody& soft_body() const { return soft_body_with(world(), read<int>("body")); }
};

std::string limitations(const Call& call) {
  std::string lines;
  for (const Limitation& limitation : call.attachment().limitations()) lines.append(limitation.text).append("\n");
  if (!lines.empty()) lines.pop_back();
  return lines;
}

std::string contacts(const Call& call) {
  if (call.detection().settings().read_out == ReadOut::off) {
    throw InvalidInput("contacts: read_out is 'off'; attach with read_out='contacts' or 'impulses'.");
  }
  call.attachment().finish_step();
  const double step_length = call.world().getDispatchInfo().m_timeStep;
  return bytes_of(std::array{step_length}) + bytes_of_contacts(call.detection().body_contacts(), step_length);
}

std::string impulses(const Call& call) {
  if (call.detection().settings().read_out != ReadOut::impulses) {
    throw InvalidInput("impulses: read_out is not 'impulses'; attach with read_out='impulses'.");
  }
  call.attachment().finish_step();
  return call.session.take_impulses();
}

std::string edge_contacts(const Call& call) {
  if (call.detection().settings().edge_contacts == EdgeContacts::off) {
    throw InvalidInput("edge_contacts: the setting is 'off'; attach with edge_contacts='report' or 'respond'.");
  }
  return bytes_of_edge_contacts(call.detection().edge_contacts(), call.world());
}

std::string intersecting_bodies(const Call& call) {
  if (call.detection().settings().untangle == Untangle::off) {
    throw InvalidInput("intersecting_bodies: untangle is off; attach with untangle=\"automatic\" or \"all\".");
  }
  return bytes_of_intersecting_bodies(call.detection().intersecting_bodies(), call.world());
}

std::string set_filters(const Call& call) {
  const std::string nodes = call.session.take_input();
  const btSoftBody& body = call.soft_body();
  BodyFilters filters;
  filters.nodes = values_in<VertexFilter>(nodes);
  filters.neighbour_rings = call.read<std::uint32_t>("neighbour_rings");
  filters.rest_distance = call.read<float>("rest_distance");
  call.detection().set_filters(body, std::move(filters));
  return {};
}

std::string input(const Call& call) {
  std::string word;
  if (call.words >> word && word == "new") call.session.take_input();
  call.session.add_input(call.input);
  return {};
}

std::string input_at(const Call& call) {
  const auto address = call.read<std::uintptr_t>("address");
  const auto size = call.read<std::size_t>("size");
  call.session.take_input();
  // NOLINTNEXTLINE(performance-no-int-to-ptr): Python passes its array's address
  call.session.add_input({reinterpret_cast<const char*>(address), size});
  return {};
}

std::string soft_bodies(const Call& call) {
  std::vector<std::int32_t> ids;
  for (const btSoftBody* const body : soft_bodies_of(call.world())) ids.push_back(ids_of(body).body);
  return bytes_of(ids);
}

std::string questions(const Call& call) {
  const std::string input = call.session.take_input();
  std::string name;
  call.words >> name;
  return ask(call.probe(), call.world(), name, input);
}

std::string near_features(const Call& call) {
  const int body = call.read<int>("body");
  const auto max_distance = call.read<double>("max_distance");
  return bytes_of_near_features(call.probe(), call.world(), body, max_distance);
}

/// Returns a function that executes `action` and answers nothing.
template <class Action>
auto silent(Action action) {
  return [action](const Call& call) {
    action(call);
    return std::string();
  };
}

using Command = std::function<std::string(const Call&)>;

const std::map<std::string, Command>& commands() {
  static const std::map<std::string, Command> all = {
      {"version", [](const Call&) { return SOFTCD_PYBULLET_VERSION; }},
      {"all_settings", [](const Call&) { return json_of_all_settings(); }},
      {"attach", silent([](const Call& call) { call.session.attach(call.server, read_settings(call.words)); })},
      {"set", silent([](const Call& call) {
         call.session.set_settings(read_settings(call.words, call.detection().settings()));
       })},
      {"settings", [](const Call& call) { return json_of(call.detection().settings()); }},
      {"is_attached", [](const Call& call) { return call.session.attachment() != nullptr ? "1" : "0"; }},
      {"limitations", limitations},
      {"finish_step", silent([](const Call& call) { call.attachment().finish_step(); })},
      {"report", [](const Call& call) { return json_of(std::as_const(call.detection())); }},
      {"stages", [](const Call& call) { return json_of_stages(call.detection()); }},
      {"messages", [](const Call& call) { return json_of(call.session.take_messages()); }},
      {"contacts", contacts},
      {"impulses", impulses},
      {"edge_contacts", edge_contacts},
      {"intersecting_bodies", intersecting_bodies},
      {"set_filters", set_filters},
      {"detach", silent([](const Call& call) { call.session.detach(); })},
      {"input", input},
      {"input_at", input_at},
      {"soft_bodies", soft_bodies},
      {"nodes", [](const Call& call) { return bytes_of_nodes(call.soft_body()); }},
      {"faces", [](const Call& call) { return bytes_of_faces(call.soft_body()); }},
      {"ask", questions},
      {"near_features", near_features},
  };
  return all;
}

}  // namespace

std::string execute(Session& session, PhysicsCommandProcessorInterface& server, std::string_view command,
                    std::string_view input) {
  std::istringstream words{std::string(command)};
  std::string verb;
  words >> verb;
  const auto found = commands().find(verb);
  if (found == commands().end()) throw InvalidInput(fmt::format("softcd's plugin knows no command '{}'.", verb));
  return found->second({session, server, words, input});
}

}  // namespace softcd::bullet::pybullet

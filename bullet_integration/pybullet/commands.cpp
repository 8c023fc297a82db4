#include "commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <initializer_list>
#include <sstream>
#include <vector>

namespace softcd::bullet::pybullet {
namespace {

/// `names` are those of the enumerators, which count from 0.
template <class Enum>
void set_choice(Enum& setting, const std::string& value, const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (value != names[i]) continue;
    setting = static_cast<Enum>(i);
    return;
  }
  throw InvalidInput(fmt::format("'{}' is none of {}.", value, fmt::join(names, ", ")));
}

void set_flag(bool& setting, const std::string& value) {
  std::uint32_t chosen = 0;
  set_choice(chosen, value, {"False", "True"});
  setting = chosen != 0;
}

void set_count(std::uint32_t& setting, const std::string& value) {
  std::istringstream in(value);
  if (value.empty() || value[0] == '-' || !(in >> setting) || !in.eof()) {
    throw InvalidInput(fmt::format("'{}' is no count.", value));
  }
}

void set(Settings& settings, const std::string& name, const std::string& value) {
  if (name == "backend") return set_choice(settings.backend, value, {"automatic", "cpu", "cuda"});
  if (name == "detection") return set_choice(settings.detection, value, {"dcd", "ccd"});
  if (name == "accuracy") return set_choice(settings.accuracy, value, {"fast", "precise", "conservative", "automatic"});
  if (name == "self_collision") return set_choice(settings.self_collision, value, {"flagged", "all", "none"});
  if (name == "edge_contacts") return set_choice(settings.edge_contacts, value, {"off", "report", "respond"});
  if (name == "contacts") return set_choice(settings.contacts, value, {"all", "closest_feature", "automatic"});
  if (name == "contacts_per_node") return set_count(settings.contacts_per_node, value);
  if (name == "rigid_meshes") return set_flag(settings.rigid_meshes, value);
  if (name == "filter_deformables") return set_flag(settings.filter_deformables, value);
  throw InvalidInput("there is no such setting.");
}

Settings read_settings(std::istream& words) {
  Settings settings;
  for (std::string word; words >> word;) {
    const std::size_t sign = word.find('=');
    const std::string name = word.substr(0, sign);
    try {
      set(settings, name, sign == std::string::npos ? "" : word.substr(sign + 1));
    } catch (const InvalidInput& error) {
      throw InvalidInput(fmt::format("{}: {}", name, error.what()));
    }
  }
  return settings;
}

std::string json(const DetectorReport& detector) {
  const Statistics& s = detector.statistics();
  return fmt::format(
      R"({{"backend": "{}", "bodies": {}, "triangles": {}, "vt_contacts": {}, "ee_contacts": {}, "ms": {}, )"
      R"("failed_steps": {}}})",
      detector.backend() == Backend::cuda ? "cuda" : "cpu", s.bodies, s.triangles, s.vt_contacts, s.ee_contacts,
      s.ms.total, detector.failed_steps());
}

std::string json(const CrossingAnswers& answers) {
  return fmt::format(R"({{"impacts": {}, "rounds": {}, "held_nodes": {}, "unavoidable": {}, "excepted": {}}})",
                     answers.impacts, answers.rounds, answers.held_nodes, answers.unavoidable, answers.excepted);
}

std::string json(const WorldDetection& detection) {
  return fmt::format(R"({{"contacts": {}, "crossings": {}, "crossing_answers": {}, "rigid_meshes": {}}})",
                     json(detection.contacts()), json(detection.crossings()), json(detection.crossing_answers()),
                     json(detection.rigid_meshes()));
}

std::string lines_of(Span<const Limitation> limitations) {
  std::string lines;
  for (const Limitation& limitation : limitations) lines.append(limitation.text).append("\n");
  return lines;
}

Attachment& attached(Session& session) {
  Attachment* const attachment = session.attachment();
  if (attachment == nullptr) throw Error("softcd is not attached; the world was reset, or it was detached.");
  return *attachment;
}

}  // namespace

std::string execute(Session& session, PhysicsCommandProcessorInterface& server, std::string_view command) {
  std::istringstream words{std::string(command)};
  std::string verb;
  words >> verb;
  if (verb == "version") return SOFTCD_PYBULLET_VERSION;
  if (verb == "is_attached") return session.attachment() != nullptr ? "1" : "0";
  if (verb == "limitations") return lines_of(attached(session).limitations());
  if (verb == "report") return json(attached(session).detection());
  if (verb == "attach") {
    session.attach(server, read_settings(words));
  } else if (verb == "finish_step") {
    attached(session).finish_step();
  } else if (verb == "detach") {
    session.detach();
  } else {
    throw InvalidInput(fmt::format("softcd's plugin knows no command '{}'.", verb));
  }
  return {};
}

}  // namespace softcd::bullet::pybullet

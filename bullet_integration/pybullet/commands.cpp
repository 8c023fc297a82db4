#include "commands.hpp"

#include <fmt/format.h>

#include <sstream>

namespace softcd::bullet::pybullet {
namespace {

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
                     json(detection.contact_report()), json(detection.crossing_report()),
                     json(detection.crossing_answers()), json(detection.rigid_mesh_report()));
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

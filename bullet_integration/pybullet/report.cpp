#include "report.hpp"

#include <fmt/format.h>

#include <utility>

#include "json.hpp"
#include "softcd/fields/options.hpp"

namespace softcd::bullet::pybullet {
namespace {

/// Returns `"name": value, ` for each member that is no struct.
template <class Struct>
std::string members_of(const Struct& object) {
  std::string text;
  for_each_field<Struct>([&](auto field) {
    using Value = typename decltype(field)::Value;
    if constexpr (std::is_enum_v<Value> || std::is_arithmetic_v<Value>) {
      text += fmt::format("{}: {}, ", quoted(field.kName), json_of_value(field.of(object)));
    }
  });
  return text;
}

std::string json_of(const DetectorReport& detector) {
  const Statistics& statistics = detector.statistics();
  Statistics shown = statistics;
  shown.backend = detector.backend();
  std::string stages = members_of(statistics.ms);
  stages.resize(stages.size() - 2);
  return fmt::format(R"({{{}"ms": {}, "stages_ms": {{{}}}, "failed_steps": {}}})", members_of(shown),
                     json_of_value(statistics.ms.total), stages, detector.failed_steps());
}

std::string json_of(const CrossingAnswers& answers) {
  return fmt::format(
      R"({{"impacts": {}, "rounds": {}, "held_nodes": {}, "unavoidable": {}, "excepted": {}, "energy": {}, )"
      R"("momentum": [{}, {}, {}]}})",
      answers.impacts, answers.rounds, answers.held_nodes, answers.unavoidable, answers.excepted,
      json_of_value(answers.energy), json_of_value(answers.momentum[0]), json_of_value(answers.momentum[1]),
      json_of_value(answers.momentum[2]));
}

std::string json_of(const std::vector<StageReport>& stages) {
  std::string text;
  for (const StageReport& stage : stages) {
    text += fmt::format(R"({}{{"stage": {}, "ran": {}, "reason": {}}})", text.empty() ? "" : ", ",
                        quoted(name_of(stage.stage)), stage.ran, quoted(stage.reason));
  }
  return "[" + text + "]";
}

}  // namespace

std::string json_of(const WorldDetection& detection) {
  return fmt::format(
      R"({{"contacts": {}, "crossings": {}, "crossing_answers": {}, "rigid_meshes": {}, "convex_shapes": {}}})",
      json_of(detection.contact_report()), json_of(detection.crossing_report()), json_of(detection.crossing_answers()),
      json_of(detection.rigid_mesh_report()), json_of(detection.convex_shape_report()));
}

std::string json_of_stages(const WorldDetection& detection) {
  return fmt::format(R"({{"contacts": {}, "crossings": {}, "rigid_meshes": {}, "convex_shapes": {}}})",
                     json_of(detection.contact_report().explain()), json_of(detection.crossing_report().explain()),
                     json_of(detection.rigid_mesh_report().explain()),
                     json_of(detection.convex_shape_report().explain()));
}

std::string json_of(const std::vector<std::pair<LogLevel, std::string>>& messages) {
  std::string text;
  for (const auto& [level, message] : messages) {
    text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ",
                        quoted(level == LogLevel::warning ? "warning" : "information"), quoted(message));
  }
  return "[" + text + "]";
}

}  // namespace softcd::bullet::pybullet

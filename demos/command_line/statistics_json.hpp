#pragma once

#include <nlohmann/json.hpp>

#include "command_line/choices.hpp"
#include "command_line/stage_times.hpp"

namespace softcd::demo {

/// Adds all members by name; the times are an object `ms`.
inline void add_statistics(nlohmann::ordered_json& json, const Statistics& statistics) {
  for_each_field<Statistics>([&](auto field) {
    if constexpr (std::is_arithmetic_v<typename decltype(field)::Value>) json[field.kName] = field.of(statistics);
  });
  json["backend"] = name_of(statistics.backend);
  for (const StageTime& stage : kStageTimes) json["ms"][stage.name] = statistics.ms.*stage.ms;
}

}  // namespace softcd::demo

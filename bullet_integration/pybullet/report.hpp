#pragma once

#include <string>
#include <vector>

#include "softcd/bullet/world_detection.hpp"

/// The results of a step as JSON.
namespace softcd::bullet::pybullet {

/// Returns the reports of all detectors and the responses to crossings, by the names of WorldDetection's functions
/// without `_report`. `ms` is the detector's time, `stages_ms` the time of each stage.
std::string json_of(const WorldDetection& detection);

/// Returns which stages of each detector ran or were skipped, and why.
std::string json_of_stages(const WorldDetection& detection);

/// Returns a list of pairs: "information" or "warning", and the message.
std::string json_of(const std::vector<std::pair<LogLevel, std::string>>& messages);

}  // namespace softcd::bullet::pybullet

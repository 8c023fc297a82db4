#pragma once

#include "softcd/core/statistics.hpp"

namespace softcd {

/// The parts that a detection's time is reported in.
enum class Stage : int { volumes, subdivision, assignment, sort, tests, features, narrow, transfer };
constexpr int kStageCount = 8;

inline double& stage_time(StageTimes& times, Stage stage) {
  double* const fields[kStageCount] = {&times.volumes, &times.subdivision, &times.assignment, &times.sort,
                                       &times.tests,   &times.features,    &times.narrow,     &times.transfer};
  return *fields[static_cast<int>(stage)];
}

}  // namespace softcd

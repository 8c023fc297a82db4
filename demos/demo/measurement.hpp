#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "scenes/scene.hpp"
#include "scenes/step_profile.hpp"

namespace softcd::demo {

/// The events of one second of simulation, or of the rest of the last one. Times are in milliseconds.
struct Row {
  double until = 0;          ///< simulated seconds
  double step_ms = 0;        ///< median
  double detection_ms = 0;   ///< median of softcd's part; NaN where Bullet detects
  std::size_t contacts = 0;  ///< median of a step
  Penetration penetration;   ///< at the end
};

struct Measurement {
  std::vector<Row> rows;
  double first_step_ms = 0;
  double median_step_ms = 0;
  double total_seconds = 0;      ///< of wall clock, in steps
  StepProfile total_profile;     ///< of all steps
  Penetration most_penetration;  ///< the maximum over all rows, for each figure by itself
};

struct Callbacks {
  std::function<void(long step)> on_step;  ///< after each step, from 1
  std::function<void(const Row&)> on_row;
};

/// Runs the scene for that many steps.
Measurement measure(Scene& scene, long steps, const Callbacks& callbacks);

}  // namespace softcd::demo

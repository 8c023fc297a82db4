#pragma once

#include <functional>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::demo {

struct Measurement {
  std::vector<Contact> contacts;
  Statistics statistics;  ///< of the last run, with median times
};

/// Detects once, or `repetitions` times after a warm-up. `before_run` receives the run, from 0, and the number of runs.
Measurement measure(CollisionPipeline& pipeline, std::uint32_t repetitions,
                    const std::function<void(std::uint32_t run, std::uint32_t count)>& before_run);

}  // namespace softcd::demo

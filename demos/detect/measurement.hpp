#pragma once

#include <array>
#include <functional>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::demo {

struct StageTime {
  const char* name;
  double StageTimes::*ms;
};

constexpr std::array<StageTime, 9> kStageTimes = {{{"total", &StageTimes::total},
                                                   {"volumes", &StageTimes::volumes},
                                                   {"subdivision", &StageTimes::subdivision},
                                                   {"assignment", &StageTimes::assignment},
                                                   {"sort", &StageTimes::sort},
                                                   {"tests", &StageTimes::tests},
                                                   {"features", &StageTimes::features},
                                                   {"narrow", &StageTimes::narrow},
                                                   {"transfer", &StageTimes::transfer}}};

/// Each stage's own median; of an even number of runs the mean of the middle two.
StageTimes median(const std::vector<StageTimes>& runs);

struct Measurement {
  std::vector<Contact> contacts;
  Statistics statistics;  ///< of the last run, with median times
};

/// Detects once, or `repetitions` times after a warm-up. `before_run` is told the run, from 0, and their number.
Measurement measure(CollisionPipeline& pipeline, std::uint32_t repetitions,
                    const std::function<void(std::uint32_t run, std::uint32_t count)>& before_run);

}  // namespace softcd::demo

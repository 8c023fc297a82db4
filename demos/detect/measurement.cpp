#include "measurement.hpp"

#include <algorithm>

#include "command_line/stage_times.hpp"

namespace softcd::demo {

Measurement measure(CollisionPipeline& pipeline, std::uint32_t repetitions,
                    const std::function<void(std::uint32_t run, std::uint32_t count)>& before_run) {
  const std::uint32_t warm_up_count = repetitions > 0 ? 1 : 0;
  const std::uint32_t run_count = warm_up_count + std::max(repetitions, 1u);
  Span<const Contact> contacts;
  std::vector<StageTimes> times;
  for (std::uint32_t run = 0; run < run_count; ++run) {
    before_run(run, run_count);
    contacts = pipeline.detect();
    if (run >= warm_up_count) times.push_back(pipeline.query.statistics().ms);
  }
  Measurement result{{contacts.begin(), contacts.end()}, pipeline.query.statistics()};
  result.statistics.ms = median(times);
  return result;
}

}  // namespace softcd::demo

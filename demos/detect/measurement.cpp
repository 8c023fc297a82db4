#include "measurement.hpp"

#include <algorithm>

namespace softcd::demo {
namespace {

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

}  // namespace

StageTimes median(const std::vector<StageTimes>& runs) {
  StageTimes result;
  for (const StageTime& stage : kStageTimes) {
    std::vector<double> values;
    values.reserve(runs.size());
    for (const StageTimes& run : runs) values.push_back(run.*stage.ms);
    result.*stage.ms = median_of(std::move(values));
  }
  return result;
}

Measurement measure(CollisionPipeline& pipeline, std::uint32_t repetitions,
                    const std::function<void(std::uint32_t run, std::uint32_t count)>& before_run) {
  const std::uint32_t warm_up_count = repetitions > 0 ? 1 : 0;
  const std::uint32_t run_count = warm_up_count + std::max(repetitions, 1u);
  Span<const Contact> contacts;
  std::vector<StageTimes> times;
  for (std::uint32_t run = 0; run < run_count; ++run) {
    before_run(run, run_count);
    contacts = pipeline.detect();
    if (run >= warm_up_count) times.push_back(pipeline.statistics().ms);
  }
  Measurement result{{contacts.begin(), contacts.end()}, pipeline.statistics()};
  result.statistics.ms = median(times);
  return result;
}

}  // namespace softcd::demo

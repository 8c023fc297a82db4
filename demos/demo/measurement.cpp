#include "measurement.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <numeric>

namespace softcd::demo {
namespace {

constexpr long kStepsPerRow = 120;  // one second of simulation

template <class Value>
Value median(std::vector<Value> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double timed_step(Scene& scene) {
  const auto start = std::chrono::steady_clock::now();
  scene.step();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

Measurement measure(Scene& scene, long steps, const Callbacks& callbacks) {
  Measurement measurement;
  StepProfiler profiler;
  const bool is_ours = scene.simulation().detection() != nullptr;
  std::vector<double> all_step_ms, step_ms, detection_ms;
  std::vector<std::size_t> contacts;
  for (long step = 1; step <= steps; ++step) {
    step_ms.push_back(timed_step(scene));
    const StepProfile profile = profiler.take();
    detection_ms.push_back(is_ours ? profile.total() : std::numeric_limits<double>::quiet_NaN());
    measurement.total_profile.contacts += profile.contacts;
    measurement.total_profile.crossings += profile.crossings;
    contacts.push_back(scene.count_contacts());
    callbacks.on_step(step);
    if (step % kStepsPerRow != 0 && step != steps) continue;

    const Row row{double(scene.time()), median(step_ms), median(detection_ms), median(contacts),
                  scene.count_penetration()};
    measurement.rows.push_back(row);
    Penetration& most = measurement.most_penetration;
    most = {std::max(most.vertices, row.penetration.vertices), std::max(most.edges, row.penetration.edges)};
    callbacks.on_row(row);
    all_step_ms.insert(all_step_ms.end(), step_ms.begin(), step_ms.end());
    step_ms.clear();
    detection_ms.clear();
    contacts.clear();
  }
  measurement.first_step_ms = all_step_ms.front();
  measurement.median_step_ms = median(all_step_ms);
  measurement.total_seconds = std::accumulate(all_step_ms.begin(), all_step_ms.end(), 0.0) / 1000;
  return measurement;
}

}  // namespace softcd::demo

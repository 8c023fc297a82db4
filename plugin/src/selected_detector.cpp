#include "selected_detector.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <utility>

namespace softcd {

SelectedDetector::SelectedDetector(Backend wanted, LogCallback log, DetectorFactory make_device,
                                   const std::string& device_problem)
    : wanted_(wanted), log_(std::move(log)), make_device_(std::move(make_device)) {
  if (wanted == Backend::cpu) {
    use_cpu("the CPU was asked for");
  } else if (make_device_) {
    use_device();
  } else if (wanted == Backend::cuda) {
    throw BackendError(
        fmt::format("the CUDA backend cannot be used: {}. Use Backend::cpu or Backend::automatic.", device_problem));
  } else {
    use_cpu(fmt::format("CUDA cannot be used: {}", device_problem));
    if (log_) log_(LogLevel::information, fmt::format("softcd runs on the CPU: {}", reason_));
  }
}

void SelectedDetector::use_cpu(const std::string& reason) {
  backend_ = Backend::cpu;
  reason_ = reason;
}

void SelectedDetector::use_device() {
  backend_ = Backend::cuda;
  reason_ = wanted_ == Backend::cuda ? "CUDA was asked for" : "a CUDA device is usable";
}

/// The detector in use, made where it was not yet, with the memory limit and the topology.
Detector& SelectedDetector::prepared() {
  Slot& slot = backend_ == Backend::cpu ? cpu_ : device_;
  if (slot.detector == nullptr) slot = {backend_ == Backend::cpu ? make_cpu_detector() : make_device_(), false};
  if (!slot.detector->set_memory_limit(memory_limit_)) slot.is_current = false;
  if (!slot.is_current) slot.detector->set_topology(topology_);
  slot.is_current = true;
  return *slot.detector;
}

/// Whether the device is in use and f(its detector) succeeds. When it fails the CPU is in use, with the same positions,
/// unless the device was asked for.
template <class F>
bool SelectedDetector::succeeds_on_device(const F& f) {
  if (backend_ == Backend::cpu) return false;
  try {
    f(prepared());
    return true;
  } catch (const DeviceError& error) {
    if (wanted_ == Backend::cuda) {
      device_ = {};
      throw BackendError(fmt::format("{}. Backend::automatic would go on with the CPU.", error.what()));
    }
    make_device_ = {};
    take_over(error.what());
  } catch (const std::bad_alloc&) {
    if (wanted_ == Backend::cuda) throw;
    take_over("the device's memory does not suffice");
  }
  return false;
}

void SelectedDetector::take_over(const std::string& problem) {
  use_cpu(problem);
  has_to_choose_ = true;
  const Slot failed = std::move(device_);  // the positions are in its memory
  device_ = {};
  if (positions_.x_t1 != nullptr) {
    const PositionArrays copy = prepared().position_arrays();
    const std::size_t count = topology_.vertex_body.size();
    std::copy_n(positions_.x_t1, count, copy.x_t1);
    if (settings_.both_ends) std::copy_n(positions_.x_t0, count, copy.x_t0);
    positions_ = copy;
  }
  if (log_ && !std::exchange(has_warned_, true)) {
    log_(LogLevel::warning, fmt::format("{}: the CPU takes over{}", problem, make_device_ ? " where it must" : ""));
  }
}

bool SelectedDetector::set_memory_limit(std::uint64_t bytes) {
  memory_limit_ = bytes;
  return true;
}

void SelectedDetector::set_topology(const SceneTopology& topology) {
  topology_ = topology;
  cpu_.is_current = device_.is_current = false;
  has_to_choose_ = true;
}

/// Where there is a device; else the choice was made for good.
void SelectedDetector::choose() {
  if (!make_device_) return;
  const std::size_t triangles = topology_.triangles.size();
  if (wanted_ == Backend::automatic && triangles < kSmallScene) {
    use_cpu(fmt::format("a scene of {} triangles, fewer than {}, is done before a GPU has started", triangles,
                        kSmallScene));
  } else {
    use_device();
  }
}

PositionArrays SelectedDetector::position_arrays() {
  if (std::exchange(has_to_choose_, false)) choose();
  positions_ = {};
  if (!succeeds_on_device([&](Detector& device) { positions_ = device.position_arrays(); })) {
    positions_ = prepared().position_arrays();
  }
  return positions_;
}

void SelectedDetector::start(const SceneBodies& bodies, const DetectionSettings& settings) {
  bodies_ = bodies;
  settings_ = settings;
  if (!succeeds_on_device([&](Detector& device) { device.start(bodies, settings); })) {
    prepared().start(bodies, settings);
  }
}

Span<const Contact> SelectedDetector::finish(Statistics& statistics) {
  Span<const Contact> contacts;
  const bool was_on_device = backend_ == Backend::cuda;
  if (!succeeds_on_device([&](Detector& device) { contacts = device.finish(statistics); })) {
    if (was_on_device) prepared().start(bodies_, settings_);
    contacts = prepared().finish(statistics);
  }
  statistics.backend = backend_;
  return contacts;
}

void SelectedDetector::report_memory(Statistics& statistics) const {
  const Slot& slot = backend_ == Backend::cpu ? cpu_ : device_;
  if (slot.detector != nullptr) slot.detector->report_memory(statistics);
}

std::unique_ptr<SelectedDetector> select_detector(const PipelineOptions& options, LogCallback log) {
  DetectorFactory make_device;
  std::string problem = options.backend != Backend::cpu ? cuda_problem() : "";
  try {
    if (options.backend != Backend::cpu && problem.empty()) make_device = cuda_detector_factory(options.cuda_stream);
  } catch (const DeviceError& error) {
    problem = error.what();
  }
  return std::make_unique<SelectedDetector>(options.backend, std::move(log), std::move(make_device), problem);
}

}  // namespace softcd

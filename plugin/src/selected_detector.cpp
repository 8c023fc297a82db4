#include "selected_detector.hpp"

#include <fmt/format.h>

#include <new>
#include <utility>

#include "softcd/error.hpp"
#include "softcd/pipeline/rank_link.hpp"

namespace softcd {

DetectorFactories machine_factories(const SceneOptions& options) {
  DetectorFactories factories = {make_cpu_detector, {}, {}};
  if (options.backend == Backend::cpu) return factories;
  factories.device_problem = cuda_problem();
  if (!factories.device_problem.empty()) return factories;
  try {
    const auto& ranks = options.communicator.link();
    const int device = ranks != nullptr && ranks->device() >= 0 ? ranks->device() : options.cuda_device;
    factories.make_device = cuda_detector_factory(device, options.cuda_stream);
    factories.make_reader = cuda_position_reader_factory(device);
  } catch (const DeviceError& error) {
    return {make_cpu_detector, {}, error.what()};
  }
  return factories;
}

SelectedDetector::SelectedDetector(Backend wanted, LogCallback log, DetectorFactories factories)
    : wanted_(wanted), log_(std::move(log)), factories_(std::move(factories)) {
  if (wanted == Backend::cpu) {
    use_cpu("the CPU was asked for");
  } else if (may_use_device()) {
    use_device();
  } else if (wanted == Backend::cuda) {
    throw BackendError(fmt::format(
        "the CUDA backend cannot be used: {}. Choose the backend `automatic`, which goes on without it, or `cpu`.",
        factories_.device_problem));
  } else {
    use_cpu(fmt::format("CUDA cannot be used: {}", factories_.device_problem));
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

/// Chooses the backend where there is a device; without one the choice is final.
void SelectedDetector::choose(std::uint64_t triangles) {
  if (!may_use_device()) return;
  if (wanted_ == Backend::automatic && triangles < kSmallScene && !scene_->positions().are_on_device()) {
    use_cpu(fmt::format("a scene of {} triangles, fewer than {}, is done before a GPU has started", triangles,
                        kSmallScene));
  } else {
    use_device();
  }
}

void SelectedDetector::start(SceneStore& scene, QueryMemories& query, const DetectionInput& input) {
  scene_ = &scene;
  query_ = &query;
  input_ = input;
  choose(input.triangle_count);
  if (!succeeds_on_device([&] { start_in(device_); })) start_in(cpu_);
}

Span<const Contact> SelectedDetector::finish(Statistics& statistics) {
  Span<const Contact> contacts;
  const bool was_on_device = backend_ == Backend::cuda;
  if (!succeeds_on_device([&] { contacts = device_.detector->finish(statistics); })) {
    if (was_on_device) start_in(cpu_);
    contacts = cpu_.detector->finish(statistics);
  }
  statistics.backend = backend_;
  return contacts;
}

/// Returns whether the device is in use and f succeeds. When f fails, switches to the CPU, unless the device was
/// requested.
template <class F>
bool SelectedDetector::succeeds_on_device(const F& f) {
  if (backend_ == Backend::cpu) return false;
  try {
    f();
    return true;
  } catch (const DeviceError& error) {
    if (wanted_ == Backend::cuda) {
      device_ = {};
      throw BackendError(fmt::format("{}. Backend::automatic would go on with the CPU.", error.what()));
    }
    factories_.make_device = {};
    take_over(error.what());
  } catch (const std::bad_alloc&) {
    if (wanted_ == Backend::cuda) throw;
    take_over("the device's memory does not suffice");
  }
  return false;
}

void SelectedDetector::take_over(const std::string& problem) {
  use_cpu(problem);
  device_ = {};
  if (log_ && !std::exchange(has_warned_, true)) {
    log_(LogLevel::warning, fmt::format("{}: the CPU takes over{}", problem, may_use_device() ? " where it must" : ""));
  }
}

void SelectedDetector::answer(SceneStore& scene, QueryMemories& probe, std::uint64_t triangle_count,
                              const ProbedScene& probed, const Questions& ask) {
  scene_ = &scene;
  query_ = &probe;
  input_ = {};
  input_.reads_t0 = probed.at_t0;
  input_.settings.covers_rounding = probed.covers_rounding;
  const auto answer_in = [&](Slot& slot) {
    const Ready there = ready(slot, &Detector::make_probe);
    there.detector.answer(there.memory, probed, ask);
  };
  choose(triangle_count);
  if (!succeeds_on_device([&] { answer_in(device_); })) answer_in(cpu_);
}

void SelectedDetector::start_in(Slot& slot) {
  const Ready there = ready(slot, &Detector::make_query);
  there.detector.start(there.memory, input_.bodies, input_.settings);
}

/// Prepares a slot; makes its detector where there is none yet.
SelectedDetector::Ready SelectedDetector::ready(Slot& slot, MakeMemory make_memory) {
  if (slot.detector == nullptr) {
    slot = {&slot == &cpu_ ? factories_.make_cpu() : factories_.make_device(), ++last_number_};
  }
  NumberedMemory& memory = &slot == &cpu_ ? query_->cpu : query_->device;
  if (memory.detector != slot.number) {
    memory = {};
    memory = {(*slot.detector.*make_memory)(), slot.number};
  }
  if (!slot.detector->set_memory_limit(memory_limit_, *memory.memory)) slot.knows_scene = false;
  tell_scene(slot);
  return {*slot.detector, *memory.memory};
}

DevicePositionReader& SelectedDetector::position_reader() {
  if (reader_ == nullptr) {
    if (!factories_.make_reader) {
      throw BackendError(
          fmt::format("positions are in a CUDA device's memory, but the scene cannot use one: {}. Set positions in the "
                      "host's memory, or choose another backend.",
                      wanted_ == Backend::cpu ? "the CPU was asked for" : factories_.device_problem));
    }
    try {
      reader_ = factories_.make_reader();
    } catch (const DeviceError& error) {
      throw BackendError(error.what());
    }
  }
  return *reader_;
}

void SelectedDetector::take_positions_to_host() {
  try {
    scene_->positions().take_to_host(position_reader());
  } catch (const DeviceError& error) {
    throw BackendError(
        fmt::format("{}, so that the CPU cannot take over: positions are in the device's memory. Set positions in the "
                    "host's memory.",
                    error.what()));
  }
}

/// Passes the scene's changes to a device. The CPU's detector reads the scene in place.
void SelectedDetector::tell_scene(Slot& slot) {
  if (&slot == &cpu_) {
    if (scene_->positions().are_on_device()) take_positions_to_host();
    if (input_.settings.covers_rounding) scene_->positions().fill_full();
    slot.detector->set_scene(scene_->arrays(), {});
    return;
  }
  const std::uint64_t full = input_.settings.covers_rounding ? scene_->positions().fill_full() : 0;
  const bool is_new = !std::exchange(slot.knows_scene, false);
  if (is_new) slot.known_full_positions = 0;
  SceneChanges changes = scene_->changes(is_new, input_.reads_t0);
  const bool tells_full = full != 0 && full != std::exchange(slot.known_full_positions, full);
  if (tells_full) scene_->positions().append_full(changes);
  SceneArrays arrays = scene_->arrays();
  if (full == 0) arrays.full_t0 = arrays.full_t1 = {};
  slot.detector->set_scene(arrays, changes);
  scene_->forget_changes(input_.reads_t0);
  slot.knows_scene = true;
}

void SelectedDetector::report_memory(Statistics& statistics) const {
  if (const Detector* const detector = detector_in_use()) detector->report_memory(statistics);
}

MemoryNeed SelectedDetector::memory_need() const {
  const Detector* const detector = detector_in_use();
  return detector != nullptr ? detector->memory_need() : MemoryNeed{};
}

TestSamples SelectedDetector::test_samples() const {
  const Detector* const detector = detector_in_use();
  return detector != nullptr ? detector->test_samples() : TestSamples{};
}

}  // namespace softcd

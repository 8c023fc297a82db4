#pragma once

#include <memory>
#include <string>

#include "scene_store.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/scene.hpp"

namespace softcd {

/// With `Backend::automatic` the CPU detects scenes of fewer triangles, because it finishes before a GPU has started.
/// Crumpled sheets on an H200 and 4 to 16 cores of its host break even between 100 and 240 triangles.
constexpr std::size_t kSmallScene = 150;

/// Functions that make detectors, or, where there is no device, the reason.
struct DetectorFactories {
  DetectorFactory make_cpu;
  DetectorFactory make_device;  ///< makes a detector, or throws; empty where there is no device
  std::string device_problem;
  DevicePositionReaderFactory make_reader = {};  ///< of positions on the device; empty where there is none
};

/// Returns the factories for this machine.
DetectorFactories machine_factories(const SceneOptions& options);

/// A query's memory for the detector with this number.
struct NumberedMemory {
  std::unique_ptr<QueryMemory> memory;
  std::uint64_t detector = 0;
};

/// A query's memory on both backends. It keeps the results until the next detection is started.
struct QueryMemories {
  NumberedMemory cpu, device;
};

/// The input of one detection.
struct DetectionInput {
  SceneBodies bodies;
  DetectionSettings settings;
  bool reads_t0 = false;
  std::uint64_t triangle_count = 0;  ///< in the scene
};

/// The detectors of a scene: on the GPU where one exists and it pays, else on the CPU. Owned by SceneCore.
/// - With `automatic`, the CPU repeats a detection in the same call when the device runs out of memory. When the device
///   fails, the CPU takes over all later detections, too. Each is warned about once.
/// - With `cuda`, a device that fails is a BackendError, and std::bad_alloc is passed on. The next detection tries the
///   device again.
class SelectedDetector {
 public:
  /// Throws BackendError when `wanted` is not available.
  SelectedDetector(Backend wanted, LogCallback log, DetectorFactories factories);

  /// Limits the bytes of either backend's memory.
  void set_memory_limit(std::uint64_t bytes) { memory_limit_ = bytes; }
  /// Starts a detection. `scene` must be up to date, and stay so until finish().
  void start(SceneStore& scene, QueryMemories& query, const DetectionInput& input);
  /// Returns the contacts on the device of the detection that was started last.
  StayingContacts staying() const { return detector_in_use()->staying(); }
  /// Waits for the detection. Contacts stay valid until the query's next detection, even if the detector is destroyed.
  Span<const Contact> finish(Statistics& statistics);
  /// Answers questions about the scene, which must be up to date. `triangle_count` decides the backend. No detection
  /// may run.
  void answer(SceneStore& scene, QueryMemories& probe, std::uint64_t triangle_count, const ProbedScene& probed,
              const Questions& ask);
  void report_memory(Statistics& statistics) const;
  /// Returns the memory that was needed by the start or finish that threw std::bad_alloc.
  MemoryNeed memory_need() const;
  /// Returns the test samples of the last finished detection.
  TestSamples test_samples() const;

  /// Returns the backend of the last detection, or the expected one of the next.
  Backend backend() const { return backend_; }
  /// Returns the reason for that backend, for explain().
  const std::string& reason() const { return reason_; }
  bool may_use_device() const { return static_cast<bool>(factories_.make_device); }
  /// Returns the reader of positions on the device. Throws BackendError where there is none.
  DevicePositionReader& position_reader();

 private:
  /// One of the two detectors.
  struct Slot {
    std::unique_ptr<Detector> detector;
    std::uint64_t number = 0;
    bool knows_scene = false;
    std::uint64_t known_full_positions = 0;  ///< see ScenePositions::fill_full(); 0: none
  };

  const Detector* detector_in_use() const { return (backend_ == Backend::cpu ? cpu_ : device_).detector.get(); }
  void use_cpu(const std::string& reason);
  void use_device();
  void choose(std::uint64_t triangles);
  void take_over(const std::string& problem);
  using MakeMemory = std::unique_ptr<QueryMemory> (Detector::*)();

  /// A slot's detector and memory, prepared: it knows the scene and the memory limit.
  struct Ready {
    Detector& detector;
    QueryMemory& memory;
  };
  Ready ready(Slot& slot, MakeMemory make_memory);
  void start_in(Slot& slot);
  void tell_scene(Slot& slot);
  void take_positions_to_host();
  template <class F>
  bool succeeds_on_device(const F& f);

  Backend wanted_;
  LogCallback log_;
  DetectorFactories factories_;
  Slot cpu_, device_;
  std::unique_ptr<DevicePositionReader> reader_;
  std::uint64_t last_number_ = 0;
  Backend backend_ = Backend::cpu;
  std::string reason_;
  bool has_warned_ = false;
  std::uint64_t memory_limit_ = 0;
  // Data of the running detection:
  SceneStore* scene_ = nullptr;
  QueryMemories* query_ = nullptr;
  DetectionInput input_;
};

}  // namespace softcd

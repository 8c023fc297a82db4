#pragma once

#include <memory>
#include <string>

#include "scene_store.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/scene.hpp"

namespace softcd {

/// With `Backend::automatic` scenes of fewer triangles go to the CPU, which is done with them before a GPU has started:
/// crumpled sheets on an H200 and 4 to 16 cores of its host break even between 100 and 240 triangles.
constexpr std::size_t kSmallScene = 150;

/// Who makes detectors, and, where there is no device, why.
struct DetectorFactories {
  DetectorFactory make_cpu;
  DetectorFactory make_device;  ///< makes a detector, or throws; empty where there is no device
  std::string device_problem;
  DevicePositionReaderFactory make_reader = {};  ///< of positions on the device; empty where there is none
};

/// This machine's.
DetectorFactories machine_factories(const SceneOptions& options);

/// A query's memory, made for a detector, which is known by a number.
struct NumberedMemory {
  std::unique_ptr<QueryMemory> memory;
  std::uint64_t detector = 0;
};

/// A query's memory on both backends. What it found stays until the next detection is started.
struct QueryMemories {
  NumberedMemory cpu, device;
};

/// One detection as detectors are told.
struct DetectionInput {
  SceneBodies bodies;
  DetectionSettings settings;
  bool reads_t0 = false;
  std::uint64_t triangle_count = 0;  ///< of the scene
};

/// The detectors behind a scene: on the GPU where there is one and it pays, else on the CPU. With `automatic`, when
/// the device runs out of memory in a detection the CPU repeats it in the same call; when the device fails, all further
/// ones too. Either is warned about once. With `cuda` a device that fails is a BackendError, and std::bad_alloc remains
/// one; the next detection tries again.
class SelectedDetector {
 public:
  /// Throws BackendError when `wanted` cannot be had.
  SelectedDetector(Backend wanted, LogCallback log, DetectorFactories factories);

  /// Most bytes of either backend's memory.
  void set_memory_limit(std::uint64_t bytes) { memory_limit_ = bytes; }
  /// `scene` is up to date, and stays so until finish().
  void start(SceneStore& scene, QueryMemories& query, const DetectionInput& input);
  /// Of the detection that was started last.
  StayingContacts staying() const { return detector_in_use()->staying(); }
  /// Contacts stay valid until the next detection of the query, however long the detector lives.
  Span<const Contact> finish(Statistics& statistics);
  /// Asks about the scene, which is up to date, which `triangle_count` decides where. No detection runs.
  void answer(SceneStore& scene, QueryMemories& probe, std::uint64_t triangle_count, const ProbedScene& probed,
              const Questions& ask);
  void report_memory(Statistics& statistics) const;
  /// Of the start or finish that has thrown std::bad_alloc.
  MemoryNeed memory_need() const;
  /// Of the last detection that was finished.
  TestSamples test_samples() const;

  /// Where the last detection ran, or the next one is expected to.
  Backend backend() const { return backend_; }
  /// Why there, for explain().
  const std::string& reason() const { return reason_; }
  bool may_use_device() const { return static_cast<bool>(factories_.make_device); }
  /// Of positions on the device. Throws BackendError where it cannot be had.
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

  /// What is behind a slot, which knows the scene and its limit on memory then.
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
  // Of the detection that runs:
  SceneStore* scene_ = nullptr;
  QueryMemories* query_ = nullptr;
  DetectionInput input_;
};

}  // namespace softcd

#pragma once

#include <memory>
#include <string>

#include "softcd/pipeline/detector.hpp"
#include "softcd/softcd.hpp"

namespace softcd {

/// With `Backend::automatic` scenes of fewer triangles go to the CPU, which is done with them before a GPU has started:
/// crumpled sheets on an H200 and 4 to 16 cores of its host break even between 100 and 240 triangles.
constexpr std::size_t kSmallScene = 150;

/// The detector behind a pipeline: on the GPU where there is one and it pays, else on the CPU. With `automatic`, when
/// the device runs out of memory in a detection the CPU repeats it in the same call; when the device fails, all further
/// ones too. Either is warned about once. With `cuda` a device that fails is a BackendError, and std::bad_alloc remains
/// one; the next detection tries again.
class SelectedDetector final : public Detector {
 public:
  /// `make_device` makes a detector on the device, or throws; where it is empty, `device_problem` says why there is no
  /// device. Throws BackendError when `wanted` cannot be had.
  SelectedDetector(Backend wanted, LogCallback log, DetectorFactory make_device, const std::string& device_problem);

  bool set_memory_limit(std::uint64_t bytes) override;
  void set_topology(const SceneTopology& topology) override;
  PositionArrays position_arrays() override;
  void start(const SceneBodies& bodies, const DetectionSettings& settings) override;
  Span<const Contact> finish(Statistics& statistics) override;
  void report_memory(Statistics& statistics) const override;

  /// Where the last detection ran, or the next one is expected to.
  Backend backend() const { return backend_; }
  /// Why there, for explain().
  const std::string& reason() const { return reason_; }

 private:
  /// One of the two detectors and whether it knows the topology.
  struct Slot {
    std::unique_ptr<Detector> detector;
    bool is_current = false;
  };

  void use_cpu(const std::string& reason);
  void use_device();
  void choose();
  void take_over(const std::string& problem);
  Detector& prepared();
  template <class F>
  bool succeeds_on_device(const F& f);

  Backend wanted_;
  LogCallback log_;
  DetectorFactory make_device_;
  Slot cpu_, device_;
  Backend backend_ = Backend::cpu;
  std::string reason_;
  bool has_to_choose_ = false;  ///< the scene is another one, or the device has just failed
  bool has_warned_ = false;
  std::uint64_t memory_limit_ = 0;
  SceneTopology topology_;
  PositionArrays positions_{};  ///< of the detector in use, written for the next detection
  SceneBodies bodies_{};        ///< of the detection that runs
  DetectionSettings settings_{};
};

/// The one that the options ask for, with this machine's devices. Throws BackendError when it cannot be had.
std::unique_ptr<SelectedDetector> select_detector(const PipelineOptions& options, LogCallback log);

}  // namespace softcd

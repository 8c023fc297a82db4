#include <memory>
#include <string>

#include "cuda_backend.cuh"
#include "occupancy.cuh"
#include "softcd/pipeline/detector_on.hpp"

namespace softcd {
namespace {

std::string find_problem() {
  int count = 0;
  const cudaError_t status = cudaGetDeviceCount(&count);
  cudaGetLastError();
  if (status != cudaSuccess) return std::string(cudaGetErrorString(status)) + " (is an NVIDIA driver installed?)";
  if (count == 0) return "there is no CUDA device";
  return {};
}

int current_device() {
  int device = 0;
  check_cuda(cudaGetDevice(&device), "cudaGetDevice");
  return device;
}

/// Makes a device the calling thread's current one for as long as it lives.
class DeviceGuard {
 public:
  explicit DeviceGuard(int device) : before_(current_device()) {
    if (device != before_) check_cuda(cudaSetDevice(device), "cudaSetDevice");
  }
  DeviceGuard(const DeviceGuard&) = delete;
  DeviceGuard& operator=(const DeviceGuard&) = delete;
  ~DeviceGuard() { cudaSetDevice(before_); }

 private:
  int before_;
};

/// A detector on one device, whichever is the calling thread's current one.
class DetectorOnDevice final : public Detector {
 public:
  DetectorOnDevice(int device, cudaStream_t stream) : device_(device) {
    const DeviceGuard guard(device_);
    detector_ = std::make_unique<DetectorOn<CudaBackend>>(stream);
  }
  DetectorOnDevice(const DetectorOnDevice&) = delete;
  DetectorOnDevice& operator=(const DetectorOnDevice&) = delete;
  /// Where the device cannot be made current any more there is nothing left to free on it.
  ~DetectorOnDevice() noexcept override {
    try {
      const DeviceGuard guard(device_);
      detector_.reset();
    } catch (...) {  // NOLINT(bugprone-empty-catch)
    }
  }

  bool set_memory_limit(std::uint64_t bytes) override {
    const DeviceGuard guard(device_);
    return detector_->set_memory_limit(bytes);
  }
  void set_topology(const SceneTopology& topology) override {
    const DeviceGuard guard(device_);
    detector_->set_topology(topology);
  }
  PositionArrays position_arrays() override {
    const DeviceGuard guard(device_);
    return detector_->position_arrays();
  }
  void start(const SceneBodies& bodies, const DetectionSettings& settings) override {
    const DeviceGuard guard(device_);
    detector_->start(bodies, settings);
  }
  Span<const Contact> finish(Statistics& statistics) override {
    const DeviceGuard guard(device_);
    return detector_->finish(statistics);
  }
  void report_memory(Statistics& statistics) const override { detector_->report_memory(statistics); }

 private:
  int device_;
  std::unique_ptr<Detector> detector_;
};

}  // namespace

DetectorFactory cuda_detector_factory(void* stream) {
  return [device = current_device(), stream] {
    return std::make_unique<DetectorOnDevice>(device, static_cast<cudaStream_t>(stream));
  };
}

const char* cuda_problem() {
  static const std::string problem = find_problem();
  return problem.c_str();
}

}  // namespace softcd

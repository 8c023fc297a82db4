#include <memory>
#include <string>

#include "cuda_backend.cuh"
#include "device_guard.hpp"
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

/// A query's memory on one device. Works on any thread, whatever its current device.
class QueryOnDevice final : public QueryMemory {
 public:
  QueryOnDevice(int device, std::unique_ptr<QueryMemory> query) : device_(device), query_(std::move(query)) {}
  QueryOnDevice(const QueryOnDevice&) = delete;
  QueryOnDevice& operator=(const QueryOnDevice&) = delete;
  ~QueryOnDevice() noexcept override {
    free_on(device_, [&] { query_.reset(); });
  }

  void release() override {
    const DeviceGuard guard(device_);
    query_->release();
  }
  QueryMemory& query() { return *query_; }

 private:
  int device_;
  std::unique_ptr<QueryMemory> query_;
};

/// A detector on one device. Works on any thread, whatever its current device.
class DetectorOnDevice final : public Detector {
 public:
  DetectorOnDevice(int device, cudaStream_t stream) : device_(device) {
    const DeviceGuard guard(device_);
    detector_ = std::make_unique<DetectorOn<CudaBackend>>(stream);
  }
  DetectorOnDevice(const DetectorOnDevice&) = delete;
  DetectorOnDevice& operator=(const DetectorOnDevice&) = delete;
  ~DetectorOnDevice() noexcept override {
    free_on(device_, [&] { detector_.reset(); });
  }

  bool set_memory_limit(std::uint64_t bytes, QueryMemory& query) override {
    const DeviceGuard guard(device_);
    return detector_->set_memory_limit(bytes, static_cast<QueryOnDevice&>(query).query());
  }
  void set_scene(const SceneArrays& scene, const SceneChanges& changes) override {
    const DeviceGuard guard(device_);
    detector_->set_scene(scene, changes);
  }
  std::unique_ptr<QueryMemory> make_query() override {
    const DeviceGuard guard(device_);
    return std::make_unique<QueryOnDevice>(device_, detector_->make_query());
  }
  void start(QueryMemory& query, const SceneBodies& bodies, const DetectionSettings& settings) override {
    const DeviceGuard guard(device_);
    detector_->start(static_cast<QueryOnDevice&>(query).query(), bodies, settings);
  }
  StayingContacts staying() const override { return detector_->staying(); }
  Span<const Contact> finish(Statistics& statistics) override {
    const DeviceGuard guard(device_);
    return detector_->finish(statistics);
  }
  std::unique_ptr<QueryMemory> make_probe() override {
    const DeviceGuard guard(device_);
    return std::make_unique<QueryOnDevice>(device_, detector_->make_probe());
  }
  void answer(QueryMemory& probe, const ProbedScene& scene, const Questions& ask) override {
    const DeviceGuard guard(device_);
    detector_->answer(static_cast<QueryOnDevice&>(probe).query(), scene, ask);
  }
  void report_memory(Statistics& statistics) const override { detector_->report_memory(statistics); }
  MemoryNeed memory_need() const override { return detector_->memory_need(); }
  TestSamples test_samples() const override { return detector_->test_samples(); }

 private:
  int device_;
  std::unique_ptr<Detector> detector_;
};

}  // namespace

DetectorFactory cuda_detector_factory(int device, void* stream) {
  device = existing_device(device);
  return [device, stream] { return std::make_unique<DetectorOnDevice>(device, static_cast<cudaStream_t>(stream)); };
}

void* allocate_shared_memory(std::uint64_t bytes) {
  void* memory = nullptr;
  const cudaError_t status = cudaHostAlloc(&memory, bytes, cudaHostAllocPortable);
  if (status == cudaSuccess) return memory;
  cudaGetLastError();
  return nullptr;
}

void free_shared_memory(void* memory) {
  cudaFreeHost(memory);
}

const char* cuda_problem() {
  static const std::string problem = find_problem();
  return problem.c_str();
}

}  // namespace softcd

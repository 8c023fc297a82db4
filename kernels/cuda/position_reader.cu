#include <cub/block/block_reduce.cuh>

#include <algorithm>
#include <memory>

#include "check.hpp"
#include "device_guard.hpp"
#include "device_memory.hpp"
#include "handles.hpp"
#include "softcd/pipeline/detector.hpp"

namespace softcd {
namespace {

constexpr int kBlockSize = 256;

struct Merge {
  __device__ StepSurvey operator()(StepSurvey a, const StepSurvey& b) const {
    a.merge(b);
    return a;
  }
};

template <class T>
__device__ void survey_as(const SurveyedVertices& vertices, const Vec3d& origin, bool needs_t0, StepSurvey& survey) {
  for (std::uint64_t v = vertices.begin + threadIdx.x; v < vertices.end; v += kBlockSize) {
    survey_vertex<T>(vertices, v, origin, needs_t0, survey);
  }
}

/// The device's copy of a run's summary, kept to be compared with the prediction: reading host memory takes long.
struct JudgedRun {
  StepSurvey survey;
  bool is_within;
};

/// Summarises each run of vertices, one block for each. All arrays but `judged` are in host memory. `judged` and
/// `predicted` are null where nothing is to be compared.
__global__ void __launch_bounds__(kBlockSize)
    survey_vertices(const SurveyedVertices* runs, Vec3d origin, bool needs_t0, StepSurvey* surveys,
                    const StepSurvey* predicted, JudgedRun* judged) {
  using Reduce = cub::BlockReduce<StepSurvey, kBlockSize>;
  __shared__ typename Reduce::TempStorage shared;
  const SurveyedVertices vertices = runs[blockIdx.x];
  StepSurvey survey;
  if (vertices.x_t1.is_double) {
    survey_as<double>(vertices, origin, needs_t0, survey);
  } else {
    survey_as<float>(vertices, origin, needs_t0, survey);
  }
  survey = Reduce(shared).Reduce(survey, Merge{});
  if (threadIdx.x != 0) return;
  if (!vertices.has_two_ends) survey.t0 = survey.t1;
  surveys[blockIdx.x] = survey;
  if (judged != nullptr) judged[blockIdx.x] = {survey, is_within(survey, predicted[blockIdx.x])};
}

/// Decides whether all positions are as predicted, for the device and for the host. Runs as one block, after
/// survey_vertices.
__global__ void __launch_bounds__(kBlockSize)
    judge_surveys(const JudgedRun* judged, std::uint32_t runs, Predicted scene, std::uint32_t* on_device,
                  std::uint32_t* on_host) {
  using Reduce = cub::BlockReduce<StepSurvey, kBlockSize>;
  __shared__ typename Reduce::TempStorage shared;
  StepSurvey all;
  bool are_within = true;
  for (std::uint32_t run = threadIdx.x; run < runs; run += kBlockSize) {
    are_within = are_within && judged[run].is_within;
    all.merge(judged[run].survey);
  }
  const bool are_all_within = __syncthreads_and(are_within ? 1 : 0) != 0;
  all = Reduce(shared).Reduce(all, Merge{});
  if (threadIdx.x != 0) return;
  *on_device = are_all_within && is_as_predicted(all, scene) ? 1U : 0U;
  *on_host = *on_device;
}

/// Reads positions on one device. Works on any thread, whatever its current device.
class CudaPositionReader final : public DevicePositionReader {
 public:
  explicit CudaPositionReader(int device) : device_(device) {
    const DeviceGuard guard(device_);
    on_device_ = std::make_unique<OnDevice>();
  }
  CudaPositionReader(const CudaPositionReader&) = delete;
  CudaPositionReader& operator=(const CudaPositionReader&) = delete;
  ~CudaPositionReader() noexcept override {
    free_on(device_, [&] { on_device_.reset(); });
  }

  int device() const override { return device_; }

  bool can_read(const void* data) override {
    cudaPointerAttributes attributes{};
    const cudaError_t status = cudaPointerGetAttributes(&attributes, data);
    if (status != cudaErrorInvalidValue) check_cuda(status, "looking where positions are");
    cudaGetLastError();
    return status == cudaSuccess && (attributes.type == cudaMemoryTypeManaged ||
                                     (attributes.type == cudaMemoryTypeDevice && attributes.device == device_));
  }

  void wait_for(void* ready) override {
    const DeviceGuard guard(device_);
    check_cuda(cudaStreamWaitEvent(stream(), static_cast<cudaEvent_t>(ready), 0), "waiting for positions");
  }

  Span<const StepSurvey> survey(Span<const SurveyedVertices> vertices, Vec3d origin, bool needs_t0) override {
    const DeviceGuard guard(device_);
    enqueue_survey(vertices, origin, needs_t0, nullptr, nullptr);
    return seen().surveys;
  }

  PredictionVerdict look(Span<const SurveyedVertices> vertices, Span<const StepSurvey> predicted,
                         const Predicted& scene, bool needs_t0) override {
    const DeviceGuard guard(device_);
    finish_looking();
    OnDevice& on_device = *on_device_;
    on_device.predicted.reserve(predicted.size());
    std::copy(predicted.begin(), predicted.end(), on_device.predicted.data());
    if (on_device.judged_capacity < predicted.size()) {
      on_device.judged_capacity = 0;
      on_device.judged = DeviceMemory<JudgedRun>(predicted.size());
      on_device.judged_capacity = predicted.size();
    }
    if (on_device.verdict.get() == nullptr) on_device.verdict = DeviceMemory<std::uint32_t>(1);
    on_device.host_verdict.reserve(1);
    enqueue_survey(vertices, scene.origin, needs_t0, on_device.predicted.data(), on_device.judged.get());
    judge_surveys<<<1, kBlockSize, 0, stream()>>>(on_device.judged.get(), static_cast<std::uint32_t>(predicted.size()),
                                                  scene, on_device.verdict.get(), on_device.host_verdict.data());
    check_cuda(cudaGetLastError(), "looking at positions");
    check_cuda(cudaEventRecord(on_device.has_surveyed.get(), stream()), "looking at positions");
    return {on_device.verdict.get(), on_device.has_surveyed.get()};
  }

  SeenPositions seen() override {
    const DeviceGuard guard(device_);
    finish_looking();
    const OnDevice& on_device = *on_device_;
    const bool are_as_predicted = on_device.host_verdict.capacity() > 0 && *on_device.host_verdict.data() != 0;
    return {{on_device.surveys.data(), on_device.survey_count}, are_as_predicted};
  }

  void copy(const GivenPositions& from, std::uint64_t count, void* to) override {
    const DeviceGuard guard(device_);
    const std::size_t size = from.is_double ? sizeof(Vec3d) : sizeof(Vec3f);
    const std::size_t stride = count > 1 ? from.stride : size;
    check_cuda(cudaMemcpy2DAsync(to, size, from.data, stride, size, count, cudaMemcpyDeviceToHost, stream()),
               "reading positions");
    check_cuda(cudaStreamSynchronize(stream()), "reading positions");
  }

 private:
  struct OnDevice {
    /// Waits for earlier work on the legacy default stream, as the caller that made the positions may expect.
    Stream stream{cudaStreamDefault};
    PinnedBuffer<SurveyedVertices> vertices;
    PinnedBuffer<StepSurvey> surveys;
    std::uint64_t survey_count = 0;
    PinnedBuffer<StepSurvey> predicted;
    DeviceMemory<JudgedRun> judged;
    std::uint64_t judged_capacity = 0;
    DeviceMemory<std::uint32_t> verdict;
    PinnedBuffer<std::uint32_t> host_verdict;
    Event has_surveyed{cudaEventDisableTiming};
    bool is_looking = false;  ///< the arrays are in use
  };

  void enqueue_survey(Span<const SurveyedVertices> vertices, const Vec3d& origin, bool needs_t0,
                      const StepSurvey* predicted, JudgedRun* judged) {
    OnDevice& on_device = *on_device_;
    finish_looking();
    on_device.vertices.reserve(vertices.size());
    on_device.surveys.reserve(vertices.size());
    on_device.survey_count = vertices.size();
    std::copy(vertices.begin(), vertices.end(), on_device.vertices.data());
    on_device.is_looking = true;
    survey_vertices<<<static_cast<unsigned>(vertices.size()), kBlockSize, 0, stream()>>>(
        on_device.vertices.data(), origin, needs_t0, on_device.surveys.data(), predicted, judged);
    check_cuda(cudaGetLastError(), "looking at positions");
  }

  void finish_looking() {
    if (!on_device_->is_looking) return;
    check_cuda(cudaStreamSynchronize(stream()), "looking at positions");
    on_device_->is_looking = false;
  }

  cudaStream_t stream() const { return on_device_->stream.get(); }

  int device_;
  std::unique_ptr<OnDevice> on_device_;
};

}  // namespace

DevicePositionReaderFactory cuda_position_reader_factory(int device) {
  device = existing_device(device);
  return [device] { return std::make_unique<CudaPositionReader>(device); };
}

}  // namespace softcd

#include "failing_cuda_calls.hpp"

#include <cuda_runtime_api.h>

#include <atomic>
#include <utility>

namespace softcd::test {
namespace {

/// Number of calls until one fails; 0 and below: it has failed, or none will.
std::atomic<std::int64_t> calls_left{0};
std::atomic<bool> goes_on{false};
std::atomic<bool> has_one_failed{false};
std::atomic<std::int64_t> living{0};
std::atomic<std::uint64_t> waits{0};
/// The error that cudaGetLastError will return.
thread_local cudaError_t last_error = cudaSuccess;

bool fails() {
  const bool is_now = calls_left.load() > 0 && calls_left.fetch_sub(1) == 1;
  if (is_now) has_one_failed = true;
  return is_now || (goes_on && has_one_failed);
}

cudaError_t failure(cudaError_t error) {
  last_error = error;
  return error;
}

}  // namespace

FailingCudaCall::FailingCudaCall(std::uint64_t n, Fails fails) {
  has_one_failed = false;
  goes_on = fails == Fails::from_then_on;
  calls_left = static_cast<std::int64_t>(n);
}
FailingCudaCall::~FailingCudaCall() {
  end();
}
void FailingCudaCall::end() {
  calls_left = 0;
  goes_on = false;
}
bool FailingCudaCall::has_failed() const {
  return has_one_failed;
}

std::uint64_t cuda_waits() {
  return waits;
}

std::int64_t living_cuda_objects() {
  return living;
}

}  // namespace softcd::test

// The linker replaces calls of `name` by calls of `__wrap_name`, and resolves `__real_name` to the original. The
// declarations are weak, because not every version of the runtime has all functions.
#define SOFTCD_REAL(name, parameters) __attribute__((weak)) cudaError_t __real_##name parameters;

// Defines a call that may fail.
#define SOFTCD_MAY_FAIL(name, parameters, arguments)                                 \
  SOFTCD_REAL(name, parameters)                                                      \
  cudaError_t __wrap_##name parameters {                                             \
    if (softcd::test::fails()) return softcd::test::failure(cudaErrorLaunchFailure); \
    return __real_##name arguments;                                                  \
  }

// Defines a call that may fail, and waits for the device.
#define SOFTCD_WAITS(name, parameters, arguments)                                    \
  SOFTCD_REAL(name, parameters)                                                      \
  cudaError_t __wrap_##name parameters {                                             \
    ++softcd::test::waits;                                                           \
    if (softcd::test::fails()) return softcd::test::failure(cudaErrorLaunchFailure); \
    return __real_##name arguments;                                                  \
  }

// Defines a call that may fail, and makes an object that must be given back.
#define SOFTCD_MAKES(name, parameters, arguments, error)            \
  SOFTCD_REAL(name, parameters)                                     \
  cudaError_t __wrap_##name parameters {                            \
    if (softcd::test::fails()) return softcd::test::failure(error); \
    const cudaError_t status = __real_##name arguments;             \
    if (status == cudaSuccess) ++softcd::test::living;              \
    return status;                                                  \
  }

// Defines a call that gives an object back.
#define SOFTCD_GIVES_BACK(name, parameters, argument)                           \
  SOFTCD_REAL(name, parameters)                                                 \
  cudaError_t __wrap_##name parameters {                                        \
    const cudaError_t status = __real_##name(argument);                         \
    if (status == cudaSuccess && (argument) != nullptr) --softcd::test::living; \
    return status;                                                              \
  }

// NOLINTBEGIN(clang-diagnostic-reserved-identifier, readability-identifier-naming): the linker gives calls these names.
extern "C" {

SOFTCD_MAKES(cudaMalloc, (void** data, std::size_t bytes), (data, bytes), cudaErrorMemoryAllocation)
SOFTCD_MAKES(cudaMallocHost, (void** data, std::size_t bytes), (data, bytes), cudaErrorMemoryAllocation)
SOFTCD_MAKES(cudaHostAlloc, (void** data, std::size_t bytes, unsigned flags), (data, bytes, flags),
             cudaErrorMemoryAllocation)
SOFTCD_MAKES(cudaStreamCreateWithFlags, (cudaStream_t * stream, unsigned flags), (stream, flags),
             cudaErrorLaunchFailure)
SOFTCD_MAKES(cudaEventCreateWithFlags, (cudaEvent_t * event, unsigned flags), (event, flags), cudaErrorLaunchFailure)
SOFTCD_MAKES(cudaGraphInstantiate, (cudaGraphExec_t * executable, cudaGraph_t graph, unsigned long long flags),
             (executable, graph, flags), cudaErrorMemoryAllocation)

SOFTCD_GIVES_BACK(cudaFree, (void* data), data)
SOFTCD_GIVES_BACK(cudaFreeHost, (void* data), data)
SOFTCD_GIVES_BACK(cudaStreamDestroy, (cudaStream_t stream), stream)
SOFTCD_GIVES_BACK(cudaEventDestroy, (cudaEvent_t event), event)
SOFTCD_GIVES_BACK(cudaGraphExecDestroy, (cudaGraphExec_t executable), executable)

SOFTCD_MAY_FAIL(cudaMemcpyAsync, (void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind, cudaStream_t s),
                (to, from, bytes, kind, s))
SOFTCD_MAY_FAIL(cudaMemcpy2DAsync,
                (void* to, std::size_t to_pitch, const void* from, std::size_t from_pitch, std::size_t width,
                 std::size_t height, cudaMemcpyKind kind, cudaStream_t s),
                (to, to_pitch, from, from_pitch, width, height, kind, s))
SOFTCD_MAY_FAIL(cudaMemsetAsync, (void* data, int value, std::size_t bytes, cudaStream_t s), (data, value, bytes, s))
SOFTCD_WAITS(cudaStreamSynchronize, (cudaStream_t stream), (stream))
SOFTCD_WAITS(cudaEventSynchronize, (cudaEvent_t event), (event))
SOFTCD_WAITS(cudaDeviceSynchronize, (), ())
SOFTCD_MAY_FAIL(cudaStreamWaitEvent, (cudaStream_t stream, cudaEvent_t event, unsigned flags), (stream, event, flags))
SOFTCD_MAY_FAIL(cudaStreamBeginCapture, (cudaStream_t stream, cudaStreamCaptureMode mode), (stream, mode))
SOFTCD_MAY_FAIL(cudaGraphLaunch, (cudaGraphExec_t executable, cudaStream_t stream), (executable, stream))
SOFTCD_MAY_FAIL(cudaEventRecord, (cudaEvent_t event, cudaStream_t stream), (event, stream))
SOFTCD_MAY_FAIL(cudaEventRecordWithFlags, (cudaEvent_t event, cudaStream_t stream, unsigned flags),
                (event, stream, flags))
SOFTCD_MAY_FAIL(cudaEventElapsedTime, (float* ms, cudaEvent_t begin, cudaEvent_t end), (ms, begin, end))
SOFTCD_MAY_FAIL(cudaGetDevice, (int* device), (device))
SOFTCD_MAY_FAIL(cudaSetDevice, (int device), (device))
SOFTCD_MAY_FAIL(cudaDeviceGetAttribute, (int* value, cudaDeviceAttr attribute, int device), (value, attribute, device))
SOFTCD_MAY_FAIL(cudaPointerGetAttributes, (cudaPointerAttributes * attributes, const void* data), (attributes, data))
SOFTCD_MAY_FAIL(cudaFuncGetAttributes, (cudaFuncAttributes * attributes, const void* function), (attributes, function))
SOFTCD_MAY_FAIL(cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags,
                (int* blocks, const void* function, int block, std::size_t shared, unsigned flags),
                (blocks, function, block, shared, flags))
SOFTCD_MAY_FAIL(cudaLaunchKernel,
                (const void* function, dim3 grid, dim3 block, void** arguments, std::size_t shared, cudaStream_t s),
                (function, grid, block, arguments, shared, s))
SOFTCD_MAY_FAIL(__cudaLaunchKernel,
                (cudaKernel_t kernel, dim3 grid, dim3 block, void** arguments, std::size_t shared, cudaStream_t s),
                (kernel, grid, block, arguments, shared, s))
SOFTCD_MAY_FAIL(cudaLaunchKernelExC, (const cudaLaunchConfig_t* config, const void* function, void** arguments),
                (config, function, arguments))

// Drops the captured work, as CUDA does.
SOFTCD_REAL(cudaStreamEndCapture, (cudaStream_t stream, cudaGraph_t* graph))
cudaError_t __wrap_cudaStreamEndCapture(cudaStream_t stream, cudaGraph_t* graph) {
  const cudaError_t status = __real_cudaStreamEndCapture(stream, graph);
  if (!softcd::test::fails()) return status;
  if (status == cudaSuccess) cudaGraphDestroy(std::exchange(*graph, nullptr));
  return softcd::test::failure(cudaErrorLaunchFailure);
}

SOFTCD_REAL(cudaGetLastError, ())
cudaError_t __wrap_cudaGetLastError() {
  const cudaError_t mine = std::exchange(softcd::test::last_error, cudaSuccess);
  const cudaError_t theirs = __real_cudaGetLastError();
  return mine != cudaSuccess ? mine : theirs;
}

SOFTCD_REAL(cudaPeekAtLastError, ())
cudaError_t __wrap_cudaPeekAtLastError() {
  return softcd::test::last_error != cudaSuccess ? softcd::test::last_error : __real_cudaPeekAtLastError();
}

}  // extern "C"
// NOLINTEND(clang-diagnostic-reserved-identifier, readability-identifier-naming)

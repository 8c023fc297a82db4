#pragma once

#include <cuda_runtime_api.h>

#include <string>

#include "check.hpp"
#include "softcd/pipeline/detector.hpp"

namespace softcd {

inline int current_device() {
  int device = 0;
  check_cuda(cudaGetDevice(&device), "cudaGetDevice");
  return device;
}

/// Returns the device, or the current one for -1. Throws DeviceError where there is no such device.
inline int existing_device(int device) {
  if (device < 0) return current_device();
  int count = 0;
  check_cuda(cudaGetDeviceCount(&count), "cudaGetDeviceCount");
  if (device < count) return device;
  throw DeviceError("cuda_device is " + std::to_string(device) + ", but there are only " + std::to_string(count) +
                    " CUDA devices, counted from 0");
}

/// Makes a device the calling thread's current one for the lifetime of this object. Clears an error that is pending
/// from the application or from a call whose failure does not matter. Otherwise it would be attributed to softcd's next
/// launch.
class DeviceGuard {
 public:
  explicit DeviceGuard(int device) : before_(current_device()) {
    cudaGetLastError();
    if (device != before_) check_cuda(cudaSetDevice(device), "cudaSetDevice");
  }
  DeviceGuard(const DeviceGuard&) = delete;
  DeviceGuard& operator=(const DeviceGuard&) = delete;
  ~DeviceGuard() { cudaSetDevice(before_); }

 private:
  int before_;
};

/// Runs f, which frees memory, on the device. When the device can no longer be made current, nothing is left to free.
template <class F>
void free_on(int device, const F& f) noexcept {
  try {
    const DeviceGuard guard(device);
    f();
  } catch (...) {  // NOLINT(bugprone-empty-catch)
  }
}

}  // namespace softcd

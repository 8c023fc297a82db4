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

/// Makes a device the calling thread's current one for as long as it lives. An error that nobody has looked at, the
/// app's or one of a call whose failure does not matter, is cleared: it would be taken for that of our next launch.
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

/// Runs f on the device. What it does is to free: where the device cannot be made current any more there is nothing
/// left to be freed on it.
template <class F>
void free_on(int device, const F& f) noexcept {
  try {
    const DeviceGuard guard(device);
    f();
  } catch (...) {  // NOLINT(bugprone-empty-catch)
  }
}

}  // namespace softcd

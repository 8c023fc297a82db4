#pragma once

#include <cstddef>
#include <vector>

#include "softcd/core/statistics.hpp"

namespace softcd::test {

/// Makes this device the calling thread's GPU from now on.
void use_device(int device);

/// Owns bytes in a backend's memory; on the CPU in the host's.
class DeviceMemory {
 public:
  DeviceMemory(Backend backend, std::size_t bytes);
  ~DeviceMemory();
  DeviceMemory(DeviceMemory&& other) noexcept;
  DeviceMemory& operator=(DeviceMemory&& other) noexcept;
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;

  std::byte* data() { return data_; }
  void write(const void* bytes, std::size_t count);

 private:
  Backend backend_;
  std::byte* data_ = nullptr;
};

std::vector<std::byte> read_device(Backend backend, const void* data, std::size_t bytes);

}  // namespace softcd::test

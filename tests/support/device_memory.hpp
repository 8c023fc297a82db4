#pragma once

#include <cstddef>
#include <vector>

namespace softcd::test {

/// Bytes in the memory of the backend under test: on the CPU the host's.
class DeviceMemory {
 public:
  explicit DeviceMemory(std::size_t bytes);
  ~DeviceMemory();
  DeviceMemory(DeviceMemory&& other) noexcept;
  DeviceMemory& operator=(DeviceMemory&& other) noexcept;
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;

  std::byte* data() { return data_; }
  void write(const std::vector<std::byte>& bytes);

 private:
  std::byte* data_ = nullptr;
};

/// `bytes` from the memory of the backend under test.
std::vector<std::byte> read_device(const void* data, std::size_t bytes);

}  // namespace softcd::test

#pragma once

#include <cuda_runtime_api.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "check.hpp"

namespace softcd {

/// Uninitialised device memory of `capacity` values, owned.
template <class T>
class DeviceMemory {
 public:
  DeviceMemory() = default;
  explicit DeviceMemory(std::uint64_t capacity) {
    if (capacity > 0) check_cuda(cudaMalloc(&data_, capacity * sizeof(T)), "cudaMalloc");
  }
  DeviceMemory(DeviceMemory&& other) noexcept : data_(std::exchange(other.data_, nullptr)) {}
  DeviceMemory& operator=(DeviceMemory&& other) noexcept {
    std::swap(data_, other.data_);
    return *this;
  }
  /// Frees nothing while a graph is captured, because even freeing a null pointer would then be an error.
  ~DeviceMemory() {
    if (data_ != nullptr) cudaFree(data_);
  }

  T* get() const { return data_; }

 private:
  T* data_ = nullptr;
};

/// Page-locked host memory that only grows, so that copies to and from the device overlap the host.
template <class T>
class PinnedBuffer {
 public:
  PinnedBuffer() = default;
  PinnedBuffer(PinnedBuffer&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), capacity_(std::exchange(other.capacity_, 0)) {}
  PinnedBuffer& operator=(PinnedBuffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  ~PinnedBuffer() {
    if (data_ != nullptr) cudaFreeHost(data_);
  }

  /// Grows the buffer to `capacity` values. Growing loses the contents.
  void reserve(std::uint64_t capacity) {
    if (capacity <= capacity_) return;
    if (data_ != nullptr) cudaFreeHost(std::exchange(data_, nullptr));
    capacity_ = 0;
    check_cuda(cudaMallocHost(&data_, capacity * sizeof(T)), "cudaMallocHost");
    capacity_ = capacity;
  }
  T* data() const { return data_; }
  std::uint64_t capacity() const { return capacity_; }

 private:
  T* data_ = nullptr;
  std::uint64_t capacity_ = 0;
};

}  // namespace softcd

#include "device_memory.hpp"

#include <cstring>
#include <new>
#include <utility>

#ifdef SOFTCD_HAS_CUDA
#include <cuda_runtime_api.h>
#endif

namespace softcd::test {
namespace {

#ifdef SOFTCD_HAS_CUDA
void check(cudaError_t status) {
  if (status != cudaSuccess) throw std::bad_alloc();
}

void* allocate(Backend backend, std::size_t bytes) {
  if (backend != Backend::cuda) return ::operator new(bytes);
  void* memory = nullptr;
  check(cudaMalloc(&memory, bytes));
  return memory;
}

void free_memory(Backend backend, void* memory) {
  if (backend == Backend::cuda) {
    cudaFree(memory);
  } else {
    ::operator delete(memory);
  }
}

void copy(Backend backend, void* to, const void* from, std::size_t bytes) {
  if (backend == Backend::cuda) {
    check(cudaMemcpy(to, from, bytes, cudaMemcpyDefault));
  } else if (bytes > 0) {
    std::memcpy(to, from, bytes);
  }
}

void make_current(int device) {
  check(cudaSetDevice(device));
}
#else
void* allocate(Backend /*backend*/, std::size_t bytes) {
  return ::operator new(bytes);
}

void free_memory(Backend /*backend*/, void* memory) {
  ::operator delete(memory);
}

void copy(Backend /*backend*/, void* to, const void* from, std::size_t bytes) {
  if (bytes > 0) std::memcpy(to, from, bytes);
}

void make_current(int /*device*/) {}
#endif

}  // namespace

void use_device(int device) {
  make_current(device);
}

DeviceMemory::DeviceMemory(Backend backend, std::size_t bytes)
    : backend_(backend), data_(static_cast<std::byte*>(allocate(backend, bytes))) {}

DeviceMemory::~DeviceMemory() {
  free_memory(backend_, data_);
}

DeviceMemory::DeviceMemory(DeviceMemory&& other) noexcept
    : backend_(other.backend_), data_(std::exchange(other.data_, nullptr)) {}

DeviceMemory& DeviceMemory::operator=(DeviceMemory&& other) noexcept {
  std::swap(backend_, other.backend_);
  std::swap(data_, other.data_);
  return *this;
}

void DeviceMemory::write(const void* bytes, std::size_t count) {
  copy(backend_, data_, bytes, count);
}

std::vector<std::byte> read_device(Backend backend, const void* data, std::size_t bytes) {
  std::vector<std::byte> result(bytes);
  copy(backend, result.data(), data, bytes);
  return result;
}

}  // namespace softcd::test

#include "device_memory.hpp"

#include <cstring>
#include <new>
#include <utility>

#include "backend_under_test.hpp"
#ifdef SOFTCD_HAS_CUDA
#include <cuda_runtime_api.h>
#endif

namespace softcd::test {
namespace {

#ifdef SOFTCD_HAS_CUDA
bool is_on_gpu() {
  return backend_under_test() == Backend::cuda;
}

void check(cudaError_t status) {
  if (status != cudaSuccess) throw std::bad_alloc();
}
#endif

void copy(void* to, const void* from, std::size_t bytes) {
  if (bytes == 0) return;
#ifdef SOFTCD_HAS_CUDA
  if (is_on_gpu()) {
    check(cudaMemcpy(to, from, bytes, cudaMemcpyDefault));
    return;
  }
#endif
  std::memcpy(to, from, bytes);
}

}  // namespace

DeviceMemory::DeviceMemory(std::size_t bytes) {
#ifdef SOFTCD_HAS_CUDA
  if (is_on_gpu()) {
    check(cudaMalloc(&data_, bytes));
    return;
  }
#endif
  data_ = static_cast<std::byte*>(::operator new(bytes));
}

DeviceMemory::~DeviceMemory() {
#ifdef SOFTCD_HAS_CUDA
  if (is_on_gpu()) {
    cudaFree(data_);
    return;
  }
#endif
  ::operator delete(data_);
}

DeviceMemory::DeviceMemory(DeviceMemory&& other) noexcept : data_(std::exchange(other.data_, nullptr)) {}

DeviceMemory& DeviceMemory::operator=(DeviceMemory&& other) noexcept {
  std::swap(data_, other.data_);
  return *this;
}

void DeviceMemory::write(const std::vector<std::byte>& bytes) {
  copy(data_, bytes.data(), bytes.size());
}

std::vector<std::byte> read_device(const void* data, std::size_t bytes) {
  std::vector<std::byte> result(bytes);
  copy(result.data(), data, bytes);
  return result;
}

}  // namespace softcd::test

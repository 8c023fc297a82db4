#include "cuda_backend.cuh"

#include "items.hpp"
#include "memory.hpp"
#include "orders.hpp"
#include "softcd/pipeline/detector.hpp"
#include "work.hpp"

namespace softcd::test {

struct Cuda {
  using Backend = CudaBackend;

  static std::string problem() { return cuda_problem(); }
  static std::unique_ptr<CudaBackend> make_backend(MemoryAccount& account) {
    return std::make_unique<CudaBackend>(account, nullptr);
  }
  template <class T>
  static void copy_in(const std::vector<T>& values, T* to) {
    check_cuda(cudaDeviceSynchronize(), "copying in");
    check_cuda(cudaMemcpy(to, values.data(), values.size() * sizeof(T), cudaMemcpyHostToDevice), "copying in");
    check_cuda(cudaDeviceSynchronize(), "copying in");
  }
  template <class T>
  static std::vector<T> copy_out(const T* from, std::uint64_t count) {
    std::vector<T> values(count);
    check_cuda(cudaDeviceSynchronize(), "copying out");
    check_cuda(cudaMemcpy(values.data(), from, count * sizeof(T), cudaMemcpyDeviceToHost), "copying out");
    return values;
  }
};

INSTANTIATE_TYPED_TEST_SUITE_P(cuda, ItemPrimitives, Cuda);
INSTANTIATE_TYPED_TEST_SUITE_P(cuda, WorkPrimitives, Cuda);
INSTANTIATE_TYPED_TEST_SUITE_P(cuda, OrderPrimitives, Cuda);
INSTANTIATE_TYPED_TEST_SUITE_P(cuda, MemoryPrimitives, Cuda);

}  // namespace softcd::test

#include "cpu_backend.hpp"

#include "items.hpp"
#include "memory.hpp"
#include "orders.hpp"
#include "softcd/pipeline/backend.hpp"
#include "work.hpp"

namespace softcd::test {
namespace {

struct Cpu {
  using Backend = CpuBackend;

  static std::string problem() { return {}; }
  static std::unique_ptr<CpuBackend> make_backend(MemoryAccount& account) {
    return std::make_unique<CpuBackend>(account);
  }
  template <class T>
  static void copy_in(const std::vector<T>& values, T* to) {
    std::copy(values.begin(), values.end(), to);
  }
  template <class T>
  static std::vector<T> copy_out(const T* from, std::uint64_t count) {
    return {from, from + count};
  }
};

/// A backend that lacks one primitive.
struct WithoutScan : CpuBackend {
  void exclusive_scan() = delete;
};
/// A backend with counts of another type than a detection reads.
struct OfOtherCounts : CpuBackend {
  int finish();
};
static_assert(DetectionBackend<CpuBackend>);
static_assert(!DetectionBackend<WithoutScan>);
static_assert(!DetectionBackend<OfOtherCounts>);

INSTANTIATE_TYPED_TEST_SUITE_P(cpu, ItemPrimitives, Cpu);
INSTANTIATE_TYPED_TEST_SUITE_P(cpu, WorkPrimitives, Cpu);
INSTANTIATE_TYPED_TEST_SUITE_P(cpu, OrderPrimitives, Cpu);
INSTANTIATE_TYPED_TEST_SUITE_P(cpu, MemoryPrimitives, Cpu);

}  // namespace
}  // namespace softcd::test

#include "failing_allocations.hpp"

#include <dlfcn.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>

namespace softcd::test {
namespace {

/// Number of calls until one fails; 0 and below: none will.
std::atomic<std::int64_t> calls_left{0};
/// Whether all later calls fail, too.
std::atomic<bool> fails_for_good{false};

/// Returns whether oneTBB's library is the caller. It allocates on threads that it starts at any time, and ends the
/// process when that fails.
bool is_one_tbb(const void* caller) {
  Dl_info info;
  return ::dladdr(caller, &info) != 0 && info.dli_fname != nullptr && std::strstr(info.dli_fname, "libtbb") != nullptr;
}

void* allocate(std::size_t size, const void* caller) {
  const std::int64_t left = calls_left.load(std::memory_order_relaxed);
  if ((left > 0 || fails_for_good.load(std::memory_order_relaxed)) && !is_one_tbb(caller)) {
    if (left <= 0 || calls_left.fetch_sub(1) == 1) throw std::bad_alloc();
  }
  void* const memory = std::malloc(size > 0 ? size : 1);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

FailingAllocation::FailingAllocation(std::uint64_t n, bool for_good) {
  calls_left = static_cast<std::int64_t>(n);
  fails_for_good = for_good;
}
FailingAllocation::~FailingAllocation() {
  fails_for_good = false;
  calls_left = 0;
}
bool FailingAllocation::has_failed() const {
  return calls_left <= 0;
}

}  // namespace softcd::test

void* operator new(std::size_t size) {
  return softcd::test::allocate(size, __builtin_return_address(0));
}
void* operator new[](std::size_t size) {
  return softcd::test::allocate(size, __builtin_return_address(0));
}
// Callers of this form continue without the memory. It is replaced so that all memory given to `delete` has one source.
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return std::malloc(size > 0 ? size : 1);
}
void* operator new[](std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return std::malloc(size > 0 ? size : 1);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t /*size*/) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t /*size*/) noexcept {
  std::free(memory);
}

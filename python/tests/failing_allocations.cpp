// A library to be preloaded. Its operator new fails on request, and counts the allocations that are alive.

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::int64_t> calls_left{0};  ///< calls until one fails; 0: none will
std::atomic<bool> has_failed{false};
std::atomic<bool> goes_on{false};  ///< whether further calls fail after the first one
std::atomic<std::int64_t> living{0};

bool fails() {
  if (goes_on && has_failed) return true;
  if (calls_left.load() <= 0 || calls_left.fetch_sub(1) != 1) return false;
  has_failed = true;
  return true;
}

void* allocate(std::size_t size) noexcept {
  void* const memory = fails() ? nullptr : std::malloc(size > 0 ? size : 1);
  if (memory != nullptr) ++living;
  return memory;
}

}  // namespace

/// Lets the `n`-th call from now on fail, and, with `for_good`, all calls after it. With 0 none fails.
extern "C" void fail_allocation(std::int64_t n, int for_good) {
  goes_on = false;
  has_failed = false;
  calls_left = n;
  goes_on = for_good != 0;
}
extern "C" int allocation_has_failed() {
  return has_failed ? 1 : 0;
}
/// Returns the number of allocations that have not been freed.
extern "C" std::int64_t living_allocations() {
  return living;
}

void* operator new(std::size_t size) {
  void* const memory = allocate(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void* operator new[](std::size_t size) {
  return operator new(size);
}
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return allocate(size);
}
void* operator new[](std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return allocate(size);
}
void operator delete(void* memory) noexcept {
  if (memory != nullptr) --living;
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  operator delete(memory);
}
void operator delete(void* memory, std::size_t /*size*/) noexcept {
  operator delete(memory);
}
void operator delete[](void* memory, std::size_t /*size*/) noexcept {
  operator delete(memory);
}

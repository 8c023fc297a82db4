#pragma once

#include <cstdint>

namespace softcd::test {

/// While it lives, the `n`-th call of operator new from its construction on, on whatever thread, throws
/// std::bad_alloc; the first is 1. With `for_good` all calls behind it do, too. oneTBB's own calls do not count.
/// Programs that use it compile failing_allocations.cpp, which replaces operator new.
class FailingAllocation {
 public:
  explicit FailingAllocation(std::uint64_t n, bool for_good = false);
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
  ~FailingAllocation();

  /// Whether there were that many calls.
  bool has_failed() const;
};

/// Calls attempt(n) for n = 1, 2 and so on until it returns false: without a failure, as an attempt that makes fewer
/// than n allocations. Returns how many failed.
template <class Attempt>
std::uint64_t for_every_allocation(const Attempt& attempt) {
  std::uint64_t n = 1;
  while (attempt(n)) ++n;
  return n - 1;
}

}  // namespace softcd::test

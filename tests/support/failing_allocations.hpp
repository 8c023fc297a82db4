#pragma once

#include <cstdint>

namespace softcd::test {

/// During its lifetime, the `n`-th call of operator new on any thread, counted from 1, throws std::bad_alloc. With
/// `for_good` all later calls do, too. oneTBB's own calls do not count. Programs that use it compile
/// failing_allocations.cpp, which replaces operator new.
class FailingAllocation {
 public:
  explicit FailingAllocation(std::uint64_t n, bool for_good = false);
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
  ~FailingAllocation();

  /// Returns whether there were that many calls.
  bool has_failed() const;
};

/// Calls attempt(n) for n = 1, 2 and so on until it returns false, because an attempt makes fewer than n allocations
/// and nothing failed. Returns how many failed.
template <class Attempt>
std::uint64_t for_every_allocation(const Attempt& attempt) {
  std::uint64_t n = 1;
  while (attempt(n)) ++n;
  return n - 1;
}

}  // namespace softcd::test

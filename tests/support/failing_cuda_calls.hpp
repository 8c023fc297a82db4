#pragma once

#include <cstdint>

namespace softcd::test {

enum class Fails { once, from_then_on };

/// While it lives, the `n`-th call of the CUDA runtime that may fail, counted from its construction on, fails without
/// having done anything; the first is 1. Allocations run out of memory, everything else is a failed launch. What frees
/// goes on working. Programs that use it compile failing_cuda_calls.cpp and are linked with `--wrap` of what it names.
class FailingCudaCall {
 public:
  FailingCudaCall(std::uint64_t n, Fails fails);
  FailingCudaCall(const FailingCudaCall&) = delete;
  FailingCudaCall& operator=(const FailingCudaCall&) = delete;
  ~FailingCudaCall();

  /// From now on no call fails.
  void end();
  /// Whether there were that many calls.
  bool has_failed() const;
};

/// Calls so far that wait for the device.
std::uint64_t cuda_waits();

/// Memory, streams, events and graphs of CUDA's that were made and not given back.
std::int64_t living_cuda_objects();

}  // namespace softcd::test

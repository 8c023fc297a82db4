#pragma once

#include <cstdint>

namespace softcd::test {

enum class Fails { once, from_then_on };

/// During its lifetime, the `n`-th call of the CUDA runtime that may fail, counted from 1, fails without having done
/// anything. Allocations run out of memory, everything else is a failed launch. Calls that free resources still work.
/// Programs that use it compile failing_cuda_calls.cpp and are linked with `--wrap` of the functions that it names.
class FailingCudaCall {
 public:
  FailingCudaCall(std::uint64_t n, Fails fails);
  FailingCudaCall(const FailingCudaCall&) = delete;
  FailingCudaCall& operator=(const FailingCudaCall&) = delete;
  ~FailingCudaCall();

  /// Lets no further call fail.
  void end();
  /// Returns whether there were that many calls.
  bool has_failed() const;
};

/// Returns the number of calls so far that wait for the device.
std::uint64_t cuda_waits();

/// Returns the number of memory blocks, streams, events and graphs of CUDA that were made and not given back.
std::int64_t living_cuda_objects();

}  // namespace softcd::test

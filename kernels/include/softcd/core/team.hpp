#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"

namespace softcd {

/// Threads that run one functor together. Every member calls the same operations in the same order and gets the same
/// results. Sums are of integers, so they do not depend on the number of members. This team has one member; on CUDA a
/// block is a team (cuda/block_team.cuh).
struct SerialTeam {
  bool is_leader() const { return true; }

  /// Returns the sum of f(i), i < count.
  template <class F>
  std::uint64_t sum(int count, const F& f) const {
    std::uint64_t total = 0;
    for (int i = 0; i < count; ++i) total += f(i);
    return total;
  }

  /// Returns the first i at which the sum of f(0) .. f(i) exceeds `threshold`, or count - 1 when no sum does.
  template <class F>
  int first_exceeding(int count, std::uint64_t threshold, const F& f) const {
    std::uint64_t total = 0;
    for (int i = 0; i < count; ++i) {
      total += f(i);
      if (total > threshold) return i;
    }
    return count - 1;
  }
};

}  // namespace softcd

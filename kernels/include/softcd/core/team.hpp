#pragma once

#include <climits>
#include <cstdint>

#include "softcd/core/host_device.hpp"

namespace softcd {

/// Threads that run one functor together. Every member calls the same operations in the same order and gets the same
/// results. Sums are of integers, so they do not depend on the number of members. This team has one member; on CUDA a
/// block is a team (cuda/block_team.cuh).
class SerialTeam {
 public:
  bool is_leader() const { return true; }

  /// Announces that later calls are about values that are 0 where `is_any` is false. Of these a team may skip those
  /// before the first other one and behind the last.
  template <class F>
  void skip_zeros(int count, const F& is_any) {
    first_ = 0;
    end_ = count;
    while (end_ > 0 && !is_any(end_ - 1)) --end_;
    while (first_ < end_ && !is_any(first_)) ++first_;
  }

  /// Returns the sum of f(i), i < count.
  template <class F>
  std::uint64_t sum(int count, const F& f) const {
    std::uint64_t total = 0;
    for (int i = first_; i < end_of(count); ++i) total += f(i);
    return total;
  }

  /// Returns the first i at which the sum of f(0) .. f(i) exceeds `threshold`, or count - 1 when no sum does.
  template <class F>
  int first_exceeding(int count, std::uint64_t threshold, const F& f) const {
    std::uint64_t total = 0;
    for (int i = first_; i < end_of(count); ++i) {
      total += f(i);
      if (total > threshold) return i;
    }
    return count - 1;
  }

 private:
  int end_of(int count) const { return count < end_ ? count : end_; }

  int first_ = 0;
  int end_ = INT_MAX;
};

}  // namespace softcd

#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "softcd/pipeline/rank_link.hpp"

namespace softcd {

/// A barrier for threads that are ranks. All call the same functions in the same order.
class MeetingPoint {
 public:
  MeetingPoint(int size, std::chrono::milliseconds patience)
      : patience_(patience), given_(static_cast<std::size_t>(size)) {}

  int size() const { return static_cast<int>(given_.size()); }

  /// Returns when all have called it. Throws LinkError if one does not within the patience, or if an earlier call
  /// failed.
  void meet() {
    const std::uint64_t round = round_.load();
    if (is_broken_) throw LinkError("another rank has failed to take part before");
    if (arrived_.fetch_add(1) + 1 == size()) {
      arrived_ = 0;
      {
        const std::lock_guard lock(mutex_);
        round_ = round + 1;
      }
      all_are_there_.notify_all();
      return;
    }
    using Clock = std::chrono::steady_clock;
    // Ranks mostly arrive at about the same time, and waking a thread takes longer than this.
    for (const auto begin = Clock::now(); Clock::now() - begin < kSleepless;) {
      if (round_ != round) return;
      std::this_thread::yield();
    }
    std::unique_lock lock(mutex_);
    all_are_there_.wait_for(lock, patience_, [&] { return round_ != round || is_broken_; });
    if (round_ == round) {
      lock.unlock();
      fail("another rank has not taken part within " + std::to_string(patience_.count()) + " ms");
    }
  }

  /// Gathers as Communicator::AllGather does.
  void all_gather(int rank, const void* mine, std::uint64_t bytes, void* all) {
    given_[static_cast<std::size_t>(rank)] = {mine, bytes};
    meet();
    bool is_equal = true;
    for (std::size_t r = 0; r < given_.size(); ++r) {
      is_equal &= given_[r].bytes == bytes;
      if (is_equal && bytes > 0) std::memcpy(static_cast<std::byte*>(all) + r * bytes, given_[r].data, bytes);
    }
    meet();
    if (!is_equal) fail("ranks exchange different numbers of bytes");
  }

 private:
  struct Given {
    const void* data = nullptr;
    std::uint64_t bytes = 0;
  };

  static constexpr std::chrono::microseconds kSleepless{50};

  [[noreturn]] void fail(const std::string& problem) {
    {
      const std::lock_guard lock(mutex_);
      is_broken_ = true;
    }
    all_are_there_.notify_all();
    throw LinkError(problem);
  }

  std::chrono::milliseconds patience_;
  std::vector<Given> given_;
  std::atomic<int> arrived_{0};
  std::atomic<std::uint64_t> round_{0};
  std::atomic<bool> is_broken_{false};
  std::mutex mutex_;
  std::condition_variable all_are_there_;
};

}  // namespace softcd

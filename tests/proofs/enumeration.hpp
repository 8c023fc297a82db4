#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <cstdio>

namespace softcd::test {

/// Counts the configurations of a proof and prints them with its time. The count has to be the domain's size, so that
/// no part of the domain is left out unseen.
class Enumeration {
 public:
  explicit Enumeration(std::uint64_t expected) : expected_(expected) {}
  Enumeration(const Enumeration&) = delete;
  Enumeration& operator=(const Enumeration&) = delete;
  ~Enumeration() {
    if (testing::Test::HasFatalFailure()) return;
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin_;
    std::printf("             %llu configurations, %.1f s\n", static_cast<unsigned long long>(count_), seconds.count());
    EXPECT_EQ(count_, expected_) << "the domain has another size";
  }

  void next() { ++count_; }
  void add(std::uint64_t count) { count_ += count; }

 private:
  std::uint64_t expected_;
  std::uint64_t count_ = 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace softcd::test

#pragma once

#include <unistd.h>

#include <chrono>
#include <string>

namespace softcd::demo {

/// A duration for people who wait: "42 s", "3 min 05 s", "2 h 10 min". `seconds` is not negative.
std::string duration_text(double seconds);

/// What is going on, in one line on standard error that is overwritten, for people at a terminal. Nothing elsewhere.
class Progress {
 public:
  void show(const std::string& text) const;
  void clear() const { show(""); }

  /// The first step begins now.
  void start() { start_ = std::chrono::steady_clock::now(); }
  /// `step` of `steps` is done; the others are expected to take as long as those so far did on average.
  void show_step(long step, long steps) const;

 private:
  bool is_terminal_ = isatty(STDERR_FILENO) != 0;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace softcd::demo

#pragma once

#include <chrono>
#include <string>

#include "command_line/terminal.hpp"

namespace softcd::demo {

/// Returns a duration as text: "42 s", "3 min 05 s", "2 h 10 min". `seconds` must not be negative.
std::string duration_text(double seconds);

/// Shows the progress in one line on standard error that is overwritten, if that is a terminal.
class Progress {
 public:
  void show(const std::string& text) const;
  void clear() const { show(""); }

  /// Starts the clock, when the first step begins.
  void start() { start_ = std::chrono::steady_clock::now(); }
  /// Shows that `step` of `steps` is done. The estimate assumes that the others take as long as the mean so far.
  void show_step(long step, long steps) const;

 private:
  bool is_terminal_ = errors_are_on_terminal();
  std::chrono::steady_clock::time_point start_;
};

}  // namespace softcd::demo

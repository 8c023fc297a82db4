#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "command_line/terminal.hpp"

namespace softcd::demo {

/// Shows the progress in one line on standard error that is overwritten, if that is a terminal.
class ProgressLine {
 public:
  ProgressLine() = default;
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() { clear(); }

  void show(const std::string& text) {
    if (is_terminal_) fmt::print(stderr, "\r\x1b[K{}", text);
  }
  void clear() { show(""); }

 private:
  bool is_terminal_ = errors_are_on_terminal();
};

}  // namespace softcd::demo

#pragma once

#include <cstdio>
#include <iostream>
#include <stdexcept>

namespace softcd::demo {

/// Flushes standard output before a program ends successfully. Throws std::runtime_error when buffered output cannot be
/// written.
inline void finish_standard_output() {
  const bool is_written = !std::cout.flush().fail() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (!is_written) throw std::runtime_error("standard output cannot be written");
}

}  // namespace softcd::demo

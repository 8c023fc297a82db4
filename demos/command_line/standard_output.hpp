#pragma once

#include <cstdio>
#include <iostream>
#include <stdexcept>

namespace softcd::demo {

/// Before a program ends well: what it has printed may still wait in buffers, and writing them may fail. Throws
/// std::runtime_error then.
inline void finish_standard_output() {
  const bool is_written = !std::cout.flush().fail() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (!is_written) throw std::runtime_error("standard output cannot be written");
}

}  // namespace softcd::demo

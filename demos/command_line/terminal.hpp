#pragma once

#if defined(_WIN32)
#include <io.h>
#else
#include <unistd.h>
#endif

namespace softcd::demo {

/// Returns whether standard error is a terminal, whose lines can be overwritten.
inline bool errors_are_on_terminal() {
  constexpr int kStandardError = 2;
#if defined(_WIN32)
  return _isatty(kStandardError) != 0;
#else
  return isatty(kStandardError) != 0;
#endif
}

}  // namespace softcd::demo

#include "progress.hpp"

#include <fmt/format.h>

#include <cmath>

namespace softcd::demo {

std::string duration_text(double seconds) {
  const long whole = std::lround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

void Progress::show(const std::string& text) const {
  if (is_terminal_) fmt::print(stderr, "\r\x1b[K{}", text);
}

void Progress::show_step(long step, long steps) const {
  const std::chrono::duration<double> so_far = std::chrono::steady_clock::now() - start_;
  const double left = so_far.count() / static_cast<double>(step) * static_cast<double>(steps - step);
  show(fmt::format("step {} of {}, {} left", step, steps, duration_text(left)));
}

}  // namespace softcd::demo

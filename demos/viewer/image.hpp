#pragma once

#include <cstdint>
#include <vector>

namespace softcd::demo {

/// An image in 8-bit RGB, rows from top to bottom.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

}  // namespace softcd::demo

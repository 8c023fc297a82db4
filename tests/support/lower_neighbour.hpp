#pragma once

#include "softcd/grid/cell_index.hpp"

namespace softcd::test {

/// Returns the lower neighbour that a bit of a mask stands for; see kMaskBits.
constexpr Cell lower_neighbour(Cell c, int bit) {
  if (bit == 12) return {c.x - 1, c.y, c.z};
  if (bit >= 9) return {c.x + bit - 10, c.y - 1, c.z};
  return {c.x + bit % 3 - 1, c.y + bit / 3 - 1, c.z - 1};
}

}  // namespace softcd::test

#pragma once

#include <algorithm>

#include "random.hpp"
#include "softcd/grid/uniform_grid.hpp"

namespace softcd::test {

constexpr int kForms[kKdopAxes][3] = {{1, 0, 0}, {0, 1, 0},  {0, 0, 1},  {1, 1, 0}, {1, 0, 1},
                                      {0, 1, 1}, {1, -1, 0}, {1, 0, -1}, {0, 1, -1}};

inline int form(Cell c, int axis) {
  return kForms[axis][0] * c.x + kForms[axis][1] * c.y + kForms[axis][2] * c.z;
}

inline bool is_member(const IntegerDop& dop, Cell c) {
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    if (form(c, axis) < dop.lo[axis] || form(c, axis) > dop.hi[axis]) return false;
  }
  return true;
}

/// Returns an integer DOP that contains at least its seed cell and extends at most `extent` from the origin. Its
/// intervals need not be tight.
inline IntegerDop random_integer_dop(Random& random, int extent) {
  const auto coordinate = [&] {
    return static_cast<int>(random.below(2U * static_cast<unsigned>(extent) + 1U)) - extent;
  };
  const Cell a{coordinate(), coordinate(), coordinate()};
  const bool is_small = random.chance(0.5);
  const Cell b = is_small ? Cell{a.x, a.y, a.z} : Cell{coordinate(), coordinate(), coordinate()};
  IntegerDop dop{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    dop.lo[axis] = std::min(form(a, axis), form(b, axis)) - static_cast<int>(random.below(3));
    dop.hi[axis] = std::max(form(a, axis), form(b, axis)) + static_cast<int>(random.below(3));
  }
  return dop;
}

}  // namespace softcd::test

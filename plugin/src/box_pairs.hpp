#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "softcd/math/box.hpp"

namespace softcd {

/// Two indices, the lower one first.
using IndexPair = std::pair<std::uint32_t, std::uint32_t>;

/// All pairs of boxes that overlap, ascending. A box whose lo.x is above its hi.x is empty and overlaps nothing.
std::vector<IndexPair> overlapping_pairs(const std::vector<Box>& boxes);

}  // namespace softcd

#pragma once

#include <array>

#include "softcd/core/types.hpp"
#include "softcd/core/vec3.hpp"

namespace softcd::demo {

/// The positions of a pair's four vertices: of the vertex, then the triangle, or of one edge, then the other.
using PairPositions = std::array<Vec3d, 4>;

/// Returns whether it is certain, in exact arithmetic, that the features pass through each other near the time `nearby`
/// in [0, 1], while their vertices move straight from x_t0 to x_t1. The vertex then changes sides inside the triangle,
/// or the edges do between their ends. Where it returns false, they may do so, too. Positions must be finite.
bool certainly_pass_through(ContactKind kind, const PairPositions& x_t0, const PairPositions& x_t1, double nearby);

}  // namespace softcd::demo

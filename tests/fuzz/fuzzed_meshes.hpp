#pragma once

#include <vector>

#include "bytes.hpp"
#include "scene.hpp"

namespace softcd::test {

/// Up to 24 triangles: a soup of few vertices, a hub that all share, slivers, a patch, points and segments.
std::vector<Triangle> fuzzed_triangles(Bytes& bytes, std::uint32_t* vertex_count);

/// Floats of sizes from 2^-20 to 2^20, as a rule one size for all; now and then NaN, infinite or beyond 1e37.
Positions3 fuzzed_positions(Bytes& bytes, std::uint32_t count);

/// Near `x`: what moves a little, a lot or not at all.
Positions3 fuzzed_motion(Bytes& bytes, const Positions3& x);

/// Any, now and then a margin that is refused.
BodySettings fuzzed_settings(Bytes& bytes);

/// Any, now and then some that are refused; contacts stay on the host.
QueryOptions fuzzed_options(Bytes& bytes);

}  // namespace softcd::test

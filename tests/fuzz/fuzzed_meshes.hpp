#pragma once

#include <vector>

#include "bytes.hpp"
#include "scene.hpp"

namespace softcd::test {

/// Returns up to 24 triangles: a soup of few vertices, a hub that all share, slivers, a patch, points and segments.
std::vector<Triangle> fuzzed_triangles(Bytes& bytes, std::uint32_t* vertex_count);

/// Returns floats of sizes from 2^-20 to 2^20, usually one size for all; now and then NaN, infinite or beyond 1e37.
Positions3 fuzzed_positions(Bytes& bytes, std::uint32_t count);

/// Returns positions near `x`: some move a little, some a lot, some not at all.
Positions3 fuzzed_motion(Bytes& bytes, const Positions3& x);

/// Returns any settings, now and then with an invalid margin.
BodySettings fuzzed_settings(Bytes& bytes);

/// Returns any options, now and then invalid ones; contacts stay on the host.
QueryOptions fuzzed_options(Bytes& bytes);

}  // namespace softcd::test

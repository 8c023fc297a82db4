#pragma once

#include <optional>
#include <span>
#include <string>

#include "softcd/core/vec3.hpp"

/// Verdicts in exact arithmetic for features whose vertices move on straight lines from t = 0 to t = 1: do they touch
/// at any time in [0, 1]? Coplanar motions and degenerate features included. Coordinates must be finite.
namespace softcd::test {

/// Rows v, f0, f1, f2 at t = 0, then at t = 1.
bool collides_vertex_triangle(std::span<const Vec3d, 8> rows);

/// Rows e0, e1, g0, g1 at t = 0, then at t = 1.
bool collides_edge_edge(std::span<const Vec3d, 8> rows);

/// lo <= t <= hi of a time in [0, 1].
struct TimeBracket {
  double lo, hi;
};

/// When the features first touch, to 2^-42; none when they do not. Rows as above.
std::optional<TimeBracket> first_contact_vertex_triangle(std::span<const Vec3d, 8> rows);
std::optional<TimeBracket> first_contact_edge_edge(std::span<const Vec3d, 8> rows);

/// A rational number in decimal figures.
struct Fraction {
  std::string numerator;
  std::string denominator;
};

/// The same for rational coordinates: x, y, z of each row.
bool collides_vertex_triangle(std::span<const Fraction, 24> coordinates);
bool collides_edge_edge(std::span<const Fraction, 24> coordinates);

/// Rows v, f0, f1, f2. Computed exactly, then rounded once (towards zero).
double squared_distance_vertex_triangle(std::span<const Vec3d, 4> rows);

/// Rows e0, e1, g0, g1. The same.
double squared_distance_edge_edge(std::span<const Vec3d, 4> rows);

}  // namespace softcd::test

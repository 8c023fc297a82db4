#pragma once

#include <optional>
#include <span>
#include <string>

#include "softcd/core/vec3.hpp"

/// Decides in exact arithmetic whether features touch at any time in [0, 1]. Their vertices move on straight lines from
/// t = 0 to t = 1. Includes coplanar motions and degenerate features. Coordinates must be finite.
namespace softcd::test {

/// Takes the rows v, f0, f1, f2 at t = 0, then at t = 1.
bool collides_vertex_triangle(std::span<const Vec3d, 8> rows);

/// Takes the rows e0, e1, g0, g1 at t = 0, then at t = 1.
bool collides_edge_edge(std::span<const Vec3d, 8> rows);

/// A bracket lo <= t <= hi of a time in [0, 1].
struct TimeBracket {
  double lo, hi;
};

/// Return the time at which the features first touch, to 2^-42; none when they do not. Rows are as above.
std::optional<TimeBracket> first_contact_vertex_triangle(std::span<const Vec3d, 8> rows);
std::optional<TimeBracket> first_contact_edge_edge(std::span<const Vec3d, 8> rows);

/// A rational number in decimal figures.
struct Fraction {
  std::string numerator;
  std::string denominator;
};

/// Decide the same for rational coordinates: x, y, z of each row.
bool collides_vertex_triangle(std::span<const Fraction, 24> coordinates);
bool collides_edge_edge(std::span<const Fraction, 24> coordinates);

/// Returns the squared distance for the rows v, f0, f1, f2. Computed exactly, then rounded once (towards zero).
double squared_distance_vertex_triangle(std::span<const Vec3d, 4> rows);

/// Returns the squared distance for the rows e0, e1, g0, g1, rounded likewise.
double squared_distance_edge_edge(std::span<const Vec3d, 4> rows);

}  // namespace softcd::test

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "softcd/core/types.hpp"

namespace softcd::test {

struct Mesh {
  std::vector<Triangle> triangles;
  std::vector<Vec3d> positions;
};

using Positions3 = std::vector<Vec3d>;

/// Rounds every coordinate to a multiple of 2^-bits. With |coordinate| < 2^(22 - bits), positions do not change when
/// the origin moves to the middle of their bounding box and they are rounded to float32. Exact verdicts on them are
/// then exact verdicts on the detector's positions.
void snap_to_grid(Positions3& positions, int bits);

struct SoupOptions {
  std::uint32_t triangle_count = 500;
  double half_extent = 4.0;     ///< triangles lie in the box [-half_extent, half_extent]^3
  double largest = 1.0;         ///< radius of the largest triangle
  double size_ratio = 1.0;      ///< largest to smallest radius; small triangles are the frequent ones
  double needle_share = 0.0;    ///< needles, about 1:1000
  double degenerate_share = 0;  ///< repeated indices, collinear and coincident vertices
  double joined_share = 0.0;    ///< triangles that reuse a vertex or an edge of an earlier one
  int grid_bits = 17;
  std::uint64_t seed = 1;
};
Mesh triangle_soup(const SoupOptions& options);

/// Returns a cloth of columns x rows vertices in the plane z = 0, `spacing` apart.
Mesh grid_cloth(std::uint32_t columns, std::uint32_t rows, double spacing);
/// Returns that cloth folded to and fro like an accordion, the layers `gap` apart, and roughened.
Mesh crumpled_cloth(std::uint32_t columns, std::uint32_t rows, double spacing, double gap, std::uint64_t seed);
/// Returns a sphere of 20 * 4^level triangles.
Mesh icosphere(int level, double radius);
Mesh torus(double major_radius, double minor_radius, std::uint32_t major_count, std::uint32_t minor_count);
/// Returns a tube along z, open at both ends.
Mesh tube(double radius, double length, std::uint32_t around, std::uint32_t along);

Mesh moved(Mesh mesh, Vec3d offset);
Mesh scaled(Mesh mesh, double factor);
/// Returns one mesh with the vertices and triangles of both.
Mesh joined(const Mesh& a, const Mesh& b);
double mean_edge_length(const Mesh& mesh);

/// Returns moved positions, for the end of a step.
Positions3 translated(const Positions3& x, Vec3d offset);
/// Returns positions turned about the axis through `centre` along z.
Positions3 rotated(const Positions3& x, Vec3d centre, double angle);
/// Returns positions in which every vertex is moved by its own random vector of at most `amplitude`.
Positions3 jittered(const Positions3& x, double amplitude, std::uint64_t seed);
/// Returns positions in which every triangle is moved by a vector of its own, most of them slowly, one in eight by up
/// to `amplitude`. Shared vertices take the last triangle's vector.
Positions3 scattered(const Mesh& mesh, double amplitude, std::uint64_t seed);
/// Returns positions pulled towards the origin, where everything meets.
Positions3 contracted(const Positions3& x, double factor);

}  // namespace softcd::test

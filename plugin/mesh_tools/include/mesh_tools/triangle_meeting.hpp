#pragma once

#include <array>
#include <cstdint>

#include "softcd/core/vec3.hpp"

namespace softcd::mesh_tools {

/// A triangle of a mesh: its vertices' numbers, which are equal where triangles share a vertex, and their positions.
struct Face {
  std::array<std::uint64_t, 3> v;
  std::array<Vec3d, 3> x;
};

enum class Meeting {
  apart,
  touching,  ///< they have a point in common, and no side passes through the other triangle's inside
  through,   ///< a side of one triangle passes through the inside of the other one
};

/// Returns how two triangles meet, exactly for all finite coordinates. Sides that share a vertex with the other
/// triangle do not count. Triangles that share an edge are therefore always apart, as for Probe::intersections().
Meeting meeting_of(const Face& a, const Face& b);

}  // namespace softcd::mesh_tools

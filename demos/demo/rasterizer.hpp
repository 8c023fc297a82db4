#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "softcd/core/vec3.hpp"

namespace softcd::demo {

/// 8-bit RGB, rows from top to bottom.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

struct Camera {
  Vec3d eye, target;
  double field_of_view;  ///< vertical, radians
};

/// A triangle with smooth normals. The colour (linear, 0 to 1) depends on the side that faces the camera; front is
/// where the vertices turn counterclockwise.
struct ShadedTriangle {
  std::array<Vec3d, 3> positions;
  std::array<Vec3d, 3> normals;
  Vec3f front, back;
  bool has_edges_drawn;  ///< as thin dark lines
};

/// Draws triangles over a checked floor, lit by one sun that casts shadows, with a depth buffer and 2 x 2 samples a
/// pixel. Plain software rendering: the same bytes on every machine with IEEE arithmetic.
Image render(const std::vector<ShadedTriangle>& triangles, double floor_height, const Camera& camera, int width,
             int height);

}  // namespace softcd::demo

#include "mesh_tools/triangle_meeting.hpp"

#include <algorithm>
#include <cmath>

#include "mesh_tools/exact_intersection.hpp"

namespace softcd::mesh_tools {
namespace {

bool do_boxes_meet(const Face& a, const Face& b) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low_a, high_a] = std::minmax({a.x[0][axis], a.x[1][axis], a.x[2][axis]});
    const auto [low_b, high_b] = std::minmax({b.x[0][axis], b.x[1][axis], b.x[2][axis]});
    if (low_a > high_b || low_b > high_a) return false;
  }
  return true;
}

bool has(const Face& face, std::uint64_t vertex) {
  return std::find(face.v.begin(), face.v.end(), vertex) != face.v.end();
}

/// Returns whether a plane across the line between their middles separates pq from the triangle. Allows for rounding,
/// and for products that underflow.
bool are_certainly_apart(Vec3d p, Vec3d q, const std::array<Vec3d, 3>& triangle) {
  const std::array<Vec3d, 5> from = {p - triangle[0], q - triangle[0], Vec3d{0, 0, 0}, triangle[1] - triangle[0],
                                     triangle[2] - triangle[0]};
  const Vec3d normal = 0.5 * (from[0] + from[1]) - (1.0 / 3.0) * (from[3] + from[4]);
  std::array<double, 5> height{};
  double error = 1e-300;
  for (std::size_t i = 0; i < 5; ++i) {
    height[i] = dot(normal, from[i]);
    for (int axis = 0; axis < 3; ++axis) error += 1e-15 * std::abs(normal[axis] * from[i][axis]);
  }
  return std::min(height[0], height[1]) > std::max({height[2], height[3], height[4]}) + error;
}

/// Returns how the sides of a meet b.
Meeting sides_with(const Face& a, const Face& b) {
  Meeting meeting = Meeting::apart;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (has(b, a.v[i]) || has(b, a.v[j]) || are_certainly_apart(a.x[i], a.x[j], b.x)) continue;
    // Qualified, because a source that is compiled as one with this one has an overload of its own.
    if (!mesh_tools::intersects(a.x[i], a.x[j], b.x)) continue;
    if (mesh_tools::passes_through(a.x[i], a.x[j], b.x)) return Meeting::through;
    meeting = Meeting::touching;
  }
  return meeting;
}

}  // namespace

Meeting meeting_of(const Face& a, const Face& b) {
  if (!do_boxes_meet(a, b)) return Meeting::apart;
  const Meeting first = sides_with(a, b);
  return first == Meeting::through ? first : std::max(first, sides_with(b, a));
}

}  // namespace softcd::mesh_tools

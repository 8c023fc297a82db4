#pragma once

#include <array>

#include "scenes/scene.hpp"
#include "scenes/vectors.hpp"

namespace softcd::demo {

/// Column by column, as OpenGL reads them.
using Matrix4 = std::array<float, 16>;

struct Ray {
  Vec3d origin;
  Vec3d direction;  ///< of length 1
};

/// The box [low, high] of a frame's coordinates, seen without perspective, onto [-1, 1] on each axis; what is nearest
/// to the viewer becomes -1.
Matrix4 orthographic(const ViewFrame& frame, Vec3d low, Vec3d high);

/// A perspective view of a point that it turns around. Points of the screen are -1 to 1, from left to right and from
/// bottom to top; `aspect` is its width over its height.
class OrbitCamera {
 public:
  explicit OrbitCamera(const View& view);

  /// Angles in radians. Stops short of looking straight down or up.
  void orbit(double to_the_left, double upwards);
  /// The target goes along, so that the point that was in the middle is at this point of the screen.
  void pan(double x, double y, double aspect);
  /// Multiplies the distance to the target.
  void zoom(double factor);

  Vec3d eye() const;
  Vec3d target() const { return target_; }
  ViewFrame frame() const { return looking_along(target_ - eye()); }
  double field_of_view() const { return field_of_view_; }

  Ray ray_through(double x, double y, double aspect) const;
  Matrix4 view_projection(double aspect) const;

 private:
  Vec3d target_;
  double distance_, azimuth_, elevation_;
  double field_of_view_;  ///< vertical, radians
};

}  // namespace softcd::demo

#pragma once

#include <array>

#include "scenes/scene.hpp"
#include "scenes/vectors.hpp"

namespace softcd::demo {

/// A matrix column by column, as OpenGL reads it.
using Matrix4 = std::array<float, 16>;

struct Ray {
  Vec3d origin;
  Vec3d direction;  ///< of length 1
};

/// Returns the parallel projection of the box [low, high] of a frame's coordinates to [-1, 1] on each axis. The point
/// nearest to the viewer gets -1.
Matrix4 orthographic(const ViewFrame& frame, Vec3d low, Vec3d high);

/// A perspective view that turns around a point. Points of the screen are from -1 to 1, from left to right and from
/// bottom to top; `aspect` is its width over its height.
class OrbitCamera {
 public:
  explicit OrbitCamera(const View& view);

  /// Turns the camera, by angles in radians. Stops just before a vertical view.
  void orbit(double to_the_left, double upwards);
  /// Moves the target so that the point in the middle moves to this point of the screen.
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

#include "viewer/camera.hpp"

#include <algorithm>
#include <cmath>

namespace softcd::demo {
namespace {

constexpr double kSteepest = 1.55;  // radians
constexpr double kNearest = 0.1;    // distances to the target
constexpr double kFurthest = 200;
constexpr double kNear = 0.05;  // clipping planes
constexpr double kFar = 300;

/// Returns a matrix whose rows give x, y, z and w as functions of a point.
Matrix4 by_rows(const std::array<Vec3d, 4>& rows, const std::array<double, 4>& offsets) {
  Matrix4 matrix{};
  for (std::size_t row = 0; row < 4; ++row) {
    for (int column = 0; column < 3; ++column) {
      matrix[4 * static_cast<std::size_t>(column) + row] = static_cast<float>(rows[row][column]);
    }
    matrix[12 + row] = static_cast<float>(offsets[row]);
  }
  return matrix;
}

}  // namespace

Matrix4 orthographic(const ViewFrame& frame, Vec3d low, Vec3d high) {
  const Vec3d scale = {2 / (high.x - low.x), 2 / (high.y - low.y), -2 / (high.z - low.z)};
  const Vec3d middle = 0.5 * (low + high);
  return by_rows({scale.x * frame.right, scale.y * frame.up, scale.z * frame.back, Vec3d{0, 0, 0}},
                 {-scale.x * middle.x, -scale.y * middle.y, -scale.z * middle.z, 1});
}

OrbitCamera::OrbitCamera(const View& view)
    : target_(to_vec3d(view.target)), field_of_view_(double(view.field_of_view)) {
  const Vec3d back = to_vec3d(view.eye) - target_;
  distance_ = std::sqrt(squared_norm(back));
  azimuth_ = std::atan2(back.x, back.z);
  elevation_ = std::asin(back.y / distance_);
}

void OrbitCamera::orbit(double to_the_left, double upwards) {
  azimuth_ -= to_the_left;
  elevation_ = std::clamp(elevation_ + upwards, -kSteepest, kSteepest);
}

void OrbitCamera::pan(double x, double y, double aspect) {
  const double half_height = distance_ * std::tan(field_of_view_ / 2);
  const ViewFrame f = frame();
  target_ = target_ - (x * half_height * aspect) * f.right - (y * half_height) * f.up;
}

void OrbitCamera::zoom(double factor) {
  distance_ = std::clamp(distance_ * factor, kNearest, kFurthest);
}

Vec3d OrbitCamera::eye() const {
  const Vec3d back = {std::cos(elevation_) * std::sin(azimuth_), std::sin(elevation_),
                      std::cos(elevation_) * std::cos(azimuth_)};
  return target_ + distance_ * back;
}

Ray OrbitCamera::ray_through(double x, double y, double aspect) const {
  const double half_height = std::tan(field_of_view_ / 2);
  const ViewFrame f = frame();
  return {eye(), unit((x * half_height * aspect) * f.right + (y * half_height) * f.up - f.back)};
}

Matrix4 OrbitCamera::view_projection(double aspect) const {
  const double focal = 1 / std::tan(field_of_view_ / 2);
  const ViewFrame f = frame();
  const Vec3d from = eye();
  // Depth -1 at kNear, 1 at kFar.
  const double scale = (kFar + kNear) / (kFar - kNear);
  const double offset = -2 * kFar * kNear / (kFar - kNear);
  const std::array<Vec3d, 4> rows = {(focal / aspect) * f.right, focal * f.up, -scale * f.back, -f.back};
  return by_rows(rows, {-dot(rows[0], from), -dot(rows[1], from), offset - dot(rows[2], from), -dot(rows[3], from)});
}

}  // namespace softcd::demo

#include "rasterizer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "look.hpp"
#include "scenes/vectors.hpp"

namespace softcd::demo {
namespace {

constexpr int kSamples = 2;  // a pixel, each way
constexpr int kShadowSize = 1536;
constexpr double kEdgeWidth = 1.2;  // samples, on each side of an edge
constexpr float kEdgeShade = 0.55F;
constexpr double kNear = 0.05;

const Vec3d kToSun = unit(kTowardsSun);

/// In samples from the top left; `depth` grows away from the viewer and is linear over the screen.
struct ScreenPoint {
  double x, y, depth;
};

/// Calls visit(column, row, w0, w1, w2) for each sample whose centre the triangle covers; w are screen weights.
template <class Visit>
void for_each_sample(const std::array<ScreenPoint, 3>& p, int width, int height, Visit visit) {
  const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
  if (area == 0 || !std::isfinite(area)) return;
  const auto clamp_to = [](double value, int limit) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(limit)));
  };
  const int first_column = clamp_to(std::floor(std::min({p[0].x, p[1].x, p[2].x})), width);
  const int last_column = clamp_to(std::ceil(std::max({p[0].x, p[1].x, p[2].x})), width);
  const int first_row = clamp_to(std::floor(std::min({p[0].y, p[1].y, p[2].y})), height);
  const int last_row = clamp_to(std::ceil(std::max({p[0].y, p[1].y, p[2].y})), height);
  for (int row = first_row; row < last_row; ++row) {
    for (int column = first_column; column < last_column; ++column) {
      const double x = column + 0.5;
      const double y = row + 0.5;
      const double w0 = ((p[1].x - x) * (p[2].y - y) - (p[1].y - y) * (p[2].x - x)) / area;
      const double w1 = ((p[2].x - x) * (p[0].y - y) - (p[2].y - y) * (p[0].x - x)) / area;
      const double w2 = 1 - w0 - w1;
      if (w0 >= 0 && w1 >= 0 && w2 >= 0) visit(column, row, w0, w1, w2);
    }
  }
}

/// Of each corner above the opposite edge, on the screen.
std::array<double, 3> heights_of(const std::array<ScreenPoint, 3>& p) {
  const double area = std::abs((p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x));
  const auto length = [](const ScreenPoint& a, const ScreenPoint& b) { return std::hypot(b.x - a.x, b.y - a.y); };
  return {area / length(p[1], p[2]), area / length(p[2], p[0]), area / length(p[0], p[1])};
}

/// Depth of what the sun sees first, over a square that holds all triangles.
class ShadowMap {
 public:
  explicit ShadowMap(const std::vector<ShadedTriangle>& triangles)
      : frame_(looking_along(-kToSun)), depths_(kShadowSize * kShadowSize, std::numeric_limits<float>::max()) {
    fit(triangles);
    for (const ShadedTriangle& triangle : triangles) {
      std::array<ScreenPoint, 3> points{};
      for (std::size_t i = 0; i < 3; ++i) points[i] = project(triangle.positions[i]);
      for_each_sample(points, kShadowSize, kShadowSize, [&](int column, int row, double w0, double w1, double w2) {
        const double depth = w0 * points[0].depth + w1 * points[1].depth + w2 * points[2].depth;
        float& stored = depths_[index(column, row)];
        stored = std::min(stored, static_cast<float>(depth));
      });
    }
  }

  /// Part of the sun that reaches the point: the mean over 3 x 3 texels.
  double lit_part(Vec3d position) const {
    const ScreenPoint point = project(position);
    int lit = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const double column = std::floor(point.x) + dx;
        const double row = std::floor(point.y) + dy;
        const bool inside = column >= 0 && row >= 0 && column < kShadowSize && row < kShadowSize;
        if (!inside || point.depth - kShadowBias <=
                           static_cast<double>(depths_[index(static_cast<int>(column), static_cast<int>(row))])) {
          ++lit;
        }
      }
    }
    return lit / 9.0;
  }

 private:
  static std::size_t index(int column, int row) {
    return static_cast<std::size_t>(row) * kShadowSize + static_cast<std::size_t>(column);
  }

  void fit(const std::vector<ShadedTriangle>& triangles) {
    double low_x = 1e30, high_x = -1e30, low_y = 1e30, high_y = -1e30;
    for (const ShadedTriangle& triangle : triangles) {
      for (const Vec3d& p : triangle.positions) {
        low_x = std::min(low_x, dot(p, frame_.right));
        high_x = std::max(high_x, dot(p, frame_.right));
        low_y = std::min(low_y, dot(p, frame_.up));
        high_y = std::max(high_y, dot(p, frame_.up));
      }
    }
    center_x_ = (low_x + high_x) / 2;
    center_y_ = (low_y + high_y) / 2;
    scale_ = kShadowSize / std::max({high_x - low_x, high_y - low_y, 1e-6}) * 0.98;
  }

  ScreenPoint project(Vec3d p) const {
    return {(dot(p, frame_.right) - center_x_) * scale_ + kShadowSize / 2.0,
            (center_y_ - dot(p, frame_.up)) * scale_ + kShadowSize / 2.0, -dot(p, frame_.back)};
  }

  ViewFrame frame_;
  std::vector<float> depths_;
  double center_x_ = 0;
  double center_y_ = 0;
  double scale_ = 1;
};

class Canvas {
 public:
  Canvas(const Camera& camera, const ShadowMap& shadows, int width, int height)
      : camera_(camera),
        shadows_(shadows),
        frame_(looking_along(camera.target - camera.eye)),
        width_(width * kSamples),
        height_(height * kSamples),
        focal_(0.5 * height_ / std::tan(camera.field_of_view / 2)),
        depths_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), kNoDepth),
        colors_(depths_.size()) {}

  void draw(const ShadedTriangle& triangle) {
    std::array<double, 3> inverse_distance{};
    std::array<ScreenPoint, 3> points{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d relative = triangle.positions[i] - camera_.eye;
      const double distance = -dot(relative, frame_.back);
      if (!(distance > kNear)) return;
      inverse_distance[i] = 1 / distance;
      points[i] = {width_ / 2.0 + focal_ * dot(relative, frame_.right) / distance,
                   height_ / 2.0 - focal_ * dot(relative, frame_.up) / distance, 0};
    }
    const Vec3d flat_normal =
        cross(triangle.positions[1] - triangle.positions[0], triangle.positions[2] - triangle.positions[0]);
    const std::array<double, 3> heights = heights_of(points);
    const bool is_front = dot(flat_normal, camera_.eye - triangle.positions[0]) > 0;
    for_each_sample(points, width_, height_, [&](int column, int row, double w0, double w1, double w2) {
      const double nearness = w0 * inverse_distance[0] + w1 * inverse_distance[1] + w2 * inverse_distance[2];
      const std::size_t sample = index(column, row);
      if (nearness <= depths_[sample]) return;
      depths_[sample] = nearness;
      const std::array<double, 3> w = {w0 * inverse_distance[0] / nearness, w1 * inverse_distance[1] / nearness,
                                       w2 * inverse_distance[2] / nearness};
      Vec3d position{0, 0, 0};
      Vec3d normal{0, 0, 0};
      for (std::size_t i = 0; i < 3; ++i) {
        position = position + w[i] * triangle.positions[i];
        normal = normal + w[i] * triangle.normals[i];
      }
      if (!is_front) normal = -normal;
      const Vec3f color = is_front ? triangle.front : triangle.back;
      const bool is_at_edge =
          triangle.has_edges_drawn && std::min({w0 * heights[0], w1 * heights[1], w2 * heights[2]}) < kEdgeWidth;
      colors_[sample] = shade(position, unit(normal), is_at_edge ? kEdgeShade * color : color);
    });
  }

  /// Floor and sky, where nothing is nearer.
  void fill_background(double floor_height) {
    for (int row = 0; row < height_; ++row) {
      for (int column = 0; column < width_; ++column) {
        const Vec3d ray = unit((column + 0.5 - width_ / 2.0) * frame_.right + (height_ / 2.0 - row - 0.5) * frame_.up -
                               focal_ * frame_.back);
        const double to_floor = ray.y < 0 ? (floor_height - camera_.eye.y) / ray.y : kFloorReach;
        const std::size_t sample = index(column, row);
        if (depths_[sample] * to_floor * -dot(ray, frame_.back) > 1) continue;
        colors_[sample] = background(ray, to_floor);
      }
    }
  }

  Image resolve() const {
    Image image{width_ / kSamples, height_ / kSamples, {}};
    image.rgb.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3);
    for (int row = 0; row < height_; row += kSamples) {
      for (int column = 0; column < width_; column += kSamples) {
        Vec3f sum{0, 0, 0};
        for (int dy = 0; dy < kSamples; ++dy) {
          for (int dx = 0; dx < kSamples; ++dx) sum = sum + colors_[index(column + dx, row + dy)];
        }
        const Vec3f mean = (1.0F / (kSamples * kSamples)) * sum;
        for (int axis = 0; axis < 3; ++axis) image.rgb.push_back(to_byte(mean[axis]));
      }
    }
    return image;
  }

 private:
  static constexpr double kNoDepth = 0;  // infinitely far: depths are stored as 1 / distance

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
  }

  Vec3f shade(Vec3d position, Vec3d normal, Vec3f color) const {
    const double towards_sun = std::max(0.0, dot(normal, kToSun));
    const double sun = towards_sun > 0 ? towards_sun * shadows_.lit_part(position) : 0;
    const Vec3d half = unit(kToSun + unit(camera_.eye - position));
    const double gloss = sun > 0 ? kGloss * std::pow(std::max(0.0, dot(normal, half)), kGlossExponent) : 0;
    const double sky = kAmbient * (0.75 + 0.25 * normal.y);
    const auto light = static_cast<float>(sky + kSun * sun);
    const auto shine = static_cast<float>(gloss);
    return light * color + Vec3f{shine, shine, shine};
  }

  Vec3f background(Vec3d ray, double to_floor) const {
    const Vec3f sky = lerp(kHorizon, kZenith, static_cast<float>(std::clamp(ray.y * 1.6, 0.0, 1.0)));
    if (to_floor >= kFloorReach) return sky;
    const Vec3d position = camera_.eye + to_floor * ray;
    const bool is_dark = (static_cast<long>(std::floor(position.x)) + static_cast<long>(std::floor(position.z))) % 2;
    const Vec3f floor = shade(position, {0, 1, 0}, is_dark ? kFloorDark : kFloorLight);
    const double haze = to_floor / kFloorReach;
    return lerp(floor, kHorizon, static_cast<float>(haze * haze));
  }

  static std::uint8_t to_byte(float linear) {
    return static_cast<std::uint8_t>(std::lround(255 * std::pow(std::clamp(linear, 0.0F, 1.0F), 1 / kGamma)));
  }

  const Camera& camera_;
  const ShadowMap& shadows_;
  ViewFrame frame_;
  int width_;
  int height_;
  double focal_;  ///< in samples
  std::vector<double> depths_;
  std::vector<Vec3f> colors_;
};

bool is_finite(const ShadedTriangle& triangle) {
  return std::all_of(triangle.positions.begin(), triangle.positions.end(),
                     [](const Vec3d& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); });
}

}  // namespace

Image render(const std::vector<ShadedTriangle>& triangles, double floor_height, const Camera& camera, int width,
             int height) {
  std::vector<ShadedTriangle> finite;
  std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(finite), is_finite);
  const ShadowMap shadows(finite);
  Canvas canvas(camera, shadows, width, height);
  for (const ShadedTriangle& triangle : finite) canvas.draw(triangle);
  canvas.fill_background(floor_height);
  return canvas.resolve();
}

}  // namespace softcd::demo

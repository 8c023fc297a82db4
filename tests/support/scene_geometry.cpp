#include "scene_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "reference_distance.hpp"

namespace softcd::test {
namespace {

std::size_t side_a_count(ContactKind kind) {
  return kind == ContactKind::vertex_triangle ? 1 : 2;
}

/// Returns the point on side a minus the point on side b.
Vec3d offset_of(const Contact& contact, const std::array<Vec3d, 4>& p) {
  Vec3d offset{0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < 4; ++i) {
    const double sign = i < side_a_count(contact.kind) ? 1.0 : -1.0;
    offset = offset + (sign * static_cast<double>(contact.weights[i])) * p[i];
  }
  return offset;
}

bool weights_are_convex(const Contact& contact) {
  constexpr float kRounding = 1e-6F;
  float sums[2] = {0.0F, 0.0F};
  for (std::size_t i = 0; i < 4; ++i) {
    const float w = contact.weights[i];
    if (!(w >= -kRounding && w <= 1.0F + kRounding)) return false;
    sums[i < side_a_count(contact.kind) ? 0 : 1] += w;
  }
  return std::abs(sums[0] - 1.0F) <= 4.0F * kRounding && std::abs(sums[1] - 1.0F) <= 4.0F * kRounding;
}

}  // namespace

SceneGeometry::SceneGeometry(const Scene& scene) : scene_(scene) {
  for (const SceneBody& body : scene) edges_.push_back(edges_of(body));
}

std::array<std::uint32_t, 4> SceneGeometry::vertices(const FeaturePair& pair) const {
  if (pair.kind == ContactKind::vertex_triangle) {
    const auto [b0, b1, b2] = scene_[pair.body_b].triangles[pair.feature_b].v;
    return {pair.feature_a, b0, b1, b2};
  }
  const auto [a0, a1] = edges_[pair.body_a][pair.feature_a].v;
  const auto [b0, b1] = edges_[pair.body_b][pair.feature_b].v;
  return {a0, a1, b0, b1};
}

std::array<Vec3d, 8> SceneGeometry::motion(const FeaturePair& pair) const {
  const std::array<std::uint32_t, 4> v = vertices(pair);
  std::array<Vec3d, 8> rows{};
  for (std::size_t i = 0; i < 4; ++i) {
    const SceneBody& body = scene_[i < side_a_count(pair.kind) ? pair.body_a : pair.body_b];
    rows[i] = body.x_t0[v[i]];
    rows[4 + i] = body.x_t1[v[i]];
  }
  return rows;
}

std::array<Vec3d, 4> SceneGeometry::positions(const FeaturePair& pair, double time) const {
  const std::array<Vec3d, 8> rows = motion(pair);
  std::array<Vec3d, 4> at{};
  for (std::size_t i = 0; i < 4; ++i) at[i] = time == 1.0 ? rows[4 + i] : lerp(rows[i], rows[4 + i], time);
  return at;
}

double SceneGeometry::distance(const FeaturePair& pair, double time) const {
  const std::array<Vec3d, 4> p = positions(pair, time);
  return static_cast<double>(pair.kind == ContactKind::vertex_triangle
                                 ? distance_vertex_triangle(p[0], p[1], p[2], p[3])
                                 : distance_edge_edge(p[0], p[1], p[2], p[3]));
}

double SceneGeometry::distance_near(const FeaturePair& pair, double time) const {
  double low = std::max(0.0, time - 0x1p-23);
  double high = std::min(1.0, time + 0x1p-23);
  for (int i = 0; i < 60; ++i) {
    const double first = low + (high - low) / 3.0;
    const double second = high - (high - low) / 3.0;
    if (distance(pair, first) < distance(pair, second)) {
      high = second;
    } else {
      low = first;
    }
  }
  return std::min({distance(pair, low), distance(pair, high), distance(pair, time)});
}

std::string SceneGeometry::flaw_of(const Contact& contact, Detection detection, double tolerance) const {
  std::ostringstream flaw;
  const FeaturePair pair = features_of(contact);
  const std::array<std::uint32_t, 4> expected = vertices(pair);
  if (!std::equal(expected.begin(), expected.end(), contact.vertices)) flaw << "vertices are not the features'; ";
  if (!weights_are_convex(contact)) flaw << "weights are not convex; ";
  const double time = contact.time_of_impact;
  if (!(time >= 0.0 && time <= 1.0) || (detection == Detection::dcd && time != 1.0)) flaw << "time " << time << "; ";
  const Vec3d normal = vec3_cast<double>(contact.normal);
  if (!(std::abs(squared_norm(normal) - 1.0) <= 1e-5)) flaw << "normal is not of unit length; ";

  const std::array<Vec3d, 4> p = positions(pair, time);
  const Vec3d offset = offset_of(contact, p);
  const double length = std::sqrt(squared_norm(offset));
  if (!(contact.distance >= 0.0F && std::abs(length - contact.distance) <= tolerance)) {
    flaw << "distance " << contact.distance << ", between its points " << length << "; ";
  }
  if (detection == Detection::dcd && std::abs(length - distance(pair, 1.0)) > tolerance) {
    flaw << "distance " << length << ", the features' " << distance(pair, 1.0) << "; ";
  }
  if (length > 1e3 * tolerance && dot(normal, offset) < 0.99 * length) flaw << "normal is not along the offset; ";
  if (flaw.tellp() > 0) flaw << "in " << pair;
  return flaw.str();
}

}  // namespace softcd::test

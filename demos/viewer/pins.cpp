#include "viewer/pins.hpp"

#include <utility>

#include "scenes/vectors.hpp"

namespace softcd::demo {
namespace {

/// Relative to the mean length of the body's links.
constexpr double kRadius = 0.25;

double mean_link_length(const btSoftBody& body) {
  double sum = 0;
  for (int i = 0; i < body.m_links.size(); ++i) sum += double(body.m_links[i].m_rl);
  return body.m_links.size() > 0 ? sum / body.m_links.size() : 0;
}

void append_octahedron(Vec3d center, double radius, std::vector<PinCorner>& corners) {
  for (const double x : {-1, 1}) {
    for (const double y : {-1, 1}) {
      for (const double z : {-1, 1}) {
        const Vec3f normal = vec3_cast<float>(unit(Vec3d{x, y, z}));
        Vec3d tips[3] = {{x, 0, 0}, {0, y, 0}, {0, 0, z}};
        if (x * y * z < 0) std::swap(tips[1], tips[2]);  // counterclockwise seen from outside
        for (const Vec3d tip : tips) corners.push_back({vec3_cast<float>(center + radius * tip), normal});
      }
    }
  }
}

}  // namespace

std::vector<PinCorner> pins_of(const btSoftBody& body) {
  std::vector<PinCorner> corners;
  const double radius = kRadius * mean_link_length(body);
  bool has_free_nodes = false;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btSoftBody::Node& node = body.m_nodes[i];
    has_free_nodes |= node.m_im > 0;
    if (!(node.m_im > 0)) append_octahedron(to_vec3d(node.m_x), radius, corners);
  }
  if (!has_free_nodes) corners.clear();
  return corners;
}

}  // namespace softcd::demo

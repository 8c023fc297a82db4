#include "scenes/penetration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <unordered_map>

#include "LinearMath/btAabbUtil2.h"
#include "mesh_tools/exact_intersection.hpp"
#include "scenes/vectors.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::demo {
namespace {

struct Corner {
  int body;
  int node;
  Vec3d position;
};

using Corners = std::array<Corner, 3>;

struct Box {
  Vec3d low, high;
};

bool is_finite(const Corners& corners) {
  return std::all_of(corners.begin(), corners.end(), [](const Corner& c) {
    return std::isfinite(c.position.x) && std::isfinite(c.position.y) && std::isfinite(c.position.z);
  });
}

std::vector<Corners> read_triangles(const std::vector<const btSoftBody*>& bodies) {
  std::vector<Corners> triangles;
  for (int b = 0; b < static_cast<int>(bodies.size()); ++b) {
    const btSoftBody& body = *bodies[static_cast<std::size_t>(b)];
    for (int f = 0; f < body.m_faces.size(); ++f) {
      Corners corners;
      for (std::size_t i = 0; i < 3; ++i) {
        const btSoftBody::Node* node = body.m_faces[f].m_n[i];
        corners[i] = {b, static_cast<int>(node - &body.m_nodes[0]), to_vec3d(node->m_x)};
      }
      if (is_finite(corners)) triangles.push_back(corners);
    }
  }
  return triangles;
}

template <std::size_t count>
Box box_of(const std::array<Corner, count>& corners) {
  Box box{corners[0].position, corners[0].position};
  for (const Corner& corner : corners) {
    const Vec3d p = corner.position;
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

bool overlap(const Box& a, const Box& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
         a.low.z <= b.high.z && b.low.z <= a.high.z;
}

bool has_vertex(const Corners& triangle, const Corner& vertex) {
  return std::any_of(triangle.begin(), triangle.end(),
                     [&](const Corner& c) { return c.body == vertex.body && c.node == vertex.node; });
}

/// Returns each edge of the triangles once.
std::vector<std::array<Corner, 2>> edges_of(const std::vector<Corners>& triangles) {
  std::vector<std::array<Corner, 2>> edges;
  for (const Corners& corners : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Corner& a = corners[i];
      const Corner& b = corners[(i + 1) % 3];
      edges.push_back(a.node < b.node ? std::array{a, b} : std::array{b, a});
    }
  }
  const auto key = [](const std::array<Corner, 2>& e) { return std::tuple(e[0].body, e[0].node, e[1].node); };
  std::sort(edges.begin(), edges.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  edges.erase(std::unique(edges.begin(), edges.end(), [&](const auto& a, const auto& b) { return key(a) == key(b); }),
              edges.end());
  return edges;
}

class TriangleGrid {
 public:
  explicit TriangleGrid(const std::vector<Corners>& triangles) {
    double sum = 0;
    for (const Corners& corners : triangles) {
      const Box box = box_of(corners);
      sum += std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z});
    }
    cell_size_ = triangles.empty() || sum == 0 ? 1 : sum / static_cast<double>(triangles.size());
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
      for_each_cell(box_of(triangles[i]), [&](std::uint64_t key) { cells_[key].push_back(i); });
    }
  }

  /// Visits the triangles near the box, some of them more than once.
  template <class Visit>
  void for_each_near(const Box& box, Visit visit) const {
    for_each_cell(box, [&](std::uint64_t key) {
      const auto cell = cells_.find(key);
      if (cell == cells_.end()) return;
      for (const std::uint32_t triangle : cell->second) visit(triangle);
    });
  }

 private:
  template <class Visit>
  void for_each_cell(const Box& box, Visit visit) const {
    const auto cell = [this](double x) { return static_cast<std::int64_t>(std::floor(x / cell_size_)); };
    for (std::int64_t x = cell(box.low.x); x <= cell(box.high.x); ++x) {
      for (std::int64_t y = cell(box.low.y); y <= cell(box.high.y); ++y) {
        for (std::int64_t z = cell(box.low.z); z <= cell(box.high.z); ++z) {
          const auto bits = [](std::int64_t i) { return static_cast<std::uint64_t>(i) & 0x1FFFFFu; };
          visit(bits(x) | bits(y) << 21 | bits(z) << 42);
        }
      }
    }
  }

  double cell_size_ = 1;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

// Returns whether `point` is vertically below one of the cloth's triangles.
bool is_below(const btSoftBody& cloth, const btVector3& point) {
  for (int f = 0; f < cloth.m_faces.size(); ++f) {
    const btSoftBody::Face& face = cloth.m_faces[f];
    const btVector3& a = face.m_n[0]->m_x;
    const btVector3& b = face.m_n[1]->m_x;
    const btVector3& c = face.m_n[2]->m_x;
    const auto area = [](const btVector3& p, const btVector3& q, const btVector3& r) {
      return (q.x() - p.x()) * (r.z() - p.z()) - (q.z() - p.z()) * (r.x() - p.x());
    };
    const btScalar whole = area(a, b, c);
    if (whole == 0) continue;
    const btScalar u = area(point, b, c) / whole;
    const btScalar v = area(a, point, c) / whole;
    if (u < 0 || v < 0 || u + v > 1) continue;
    if (point.y() < u * a.y() + v * b.y() + (1 - u - v) * c.y()) return true;
  }
  return false;
}

}  // namespace

Intersections find_intersections(const std::vector<const btSoftBody*>& bodies, const IntersectionFilter& counts) {
  Intersections found;
  found.vertices.reserve(bodies.size());
  for (const btSoftBody* body : bodies) {
    found.vertices.emplace_back(static_cast<std::size_t>(body->m_nodes.size()), false);
  }
  const std::vector<Corners> triangles = read_triangles(bodies);
  const TriangleGrid grid(triangles);
  const auto mark = [&](const Corner& corner) {
    found.vertices[static_cast<std::size_t>(corner.body)][static_cast<std::size_t>(corner.node)] = true;
  };
  const auto do_count = [&](int edges, int faces) {
    return !counts || counts(*bodies[static_cast<std::size_t>(edges)], *bodies[static_cast<std::size_t>(faces)]);
  };
  for (const auto& [a, b] : edges_of(triangles)) {
    const Box box = box_of(std::array{a, b});
    bool is_apart = true;
    grid.for_each_near(box, [&, &a = a, &b = b](std::uint32_t index) {
      const Corners& t = triangles[index];
      is_apart =
          is_apart && (!overlap(box, box_of(t)) || has_vertex(t, a) || has_vertex(t, b) ||
                       !mesh_tools::intersects(a.position, b.position, {t[0].position, t[1].position, t[2].position}) ||
                       !do_count(a.body, t[0].body));
    });
    if (is_apart) continue;
    ++found.edge_count;
    mark(a);
    mark(b);
  }
  return found;
}

bool is_inside(const btSoftBody& closed, const btVector3& point) {
  // The solid angle of each triangle by Van Oosterom and Strackee, The Solid Angle of a Plane Triangle (1983).
  double half_angles = 0;
  const Vec3d origin = to_vec3d(point);
  for (int f = 0; f < closed.m_faces.size(); ++f) {
    const btSoftBody::Face& face = closed.m_faces[f];
    const Vec3d a = to_vec3d(face.m_n[0]->m_x) - origin;
    const Vec3d b = to_vec3d(face.m_n[1]->m_x) - origin;
    const Vec3d c = to_vec3d(face.m_n[2]->m_x) - origin;
    const double a_norm = std::sqrt(squared_norm(a));
    const double b_norm = std::sqrt(squared_norm(b));
    const double c_norm = std::sqrt(squared_norm(c));
    half_angles += std::atan2(dot(a, cross(b, c)),
                              a_norm * b_norm * c_norm + dot(a, b) * c_norm + dot(b, c) * a_norm + dot(c, a) * b_norm);
  }
  return std::abs(half_angles) > SIMD_PI;
}

void mark_inside(const btSoftBody& closed, const btSoftBody& body, std::vector<bool>& marked) {
  btVector3 low = closed.m_nodes[0].m_x;
  btVector3 high = low;
  for (int i = 1; i < closed.m_nodes.size(); ++i) {
    low.setMin(closed.m_nodes[i].m_x);
    high.setMax(closed.m_nodes[i].m_x);
  }
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& x = body.m_nodes[i].m_x;
    if (TestPointAgainstAabb2(low, high, x) && is_inside(closed, x)) marked[static_cast<std::size_t>(i)] = true;
  }
}

void mark_below(const btSoftBody& sheet, const btSoftBody& body, std::vector<bool>& marked) {
  btVector3 low, high;
  sheet.getAabb(low, high);
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& x = body.m_nodes[i].m_x;
    if (x.y() < high.y() && is_below(sheet, x)) marked[static_cast<std::size_t>(i)] = true;
  }
}

}  // namespace softcd::demo

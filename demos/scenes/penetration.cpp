#include "scenes/penetration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "softcd/math/vec3.hpp"

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

Vec3d to_vec3d(const btVector3& v) {
  return {double(v.x()), double(v.y()), double(v.z())};
}

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

Box box_of(const Corners& c) {
  Box box{c[0].position, c[0].position};
  for (const Corner& corner : c) {
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

double volume(Vec3d a, Vec3d b, Vec3d c, Vec3d d) {
  return dot(b - a, cross(c - a, d - a));
}

// Both ends strictly on different sides of the triangle, and the line through its inside.
bool pierces(Vec3d p, Vec3d q, const Corners& t) {
  const Vec3d a = t[0].position;
  const Vec3d b = t[1].position;
  const Vec3d c = t[2].position;
  if (volume(p, a, b, c) * volume(q, a, b, c) >= 0) return false;
  const double ab = volume(p, q, a, b);
  const double bc = volume(p, q, b, c);
  const double ca = volume(p, q, c, a);
  return (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
}

bool share_vertex(const Corners& a, const Corners& b) {
  for (const Corner& i : a) {
    for (const Corner& j : b) {
      if (i.body == j.body && i.node == j.node) return true;
    }
  }
  return false;
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

  /// Some triangles more than once.
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

}  // namespace

std::vector<std::vector<bool>> find_piercing_vertices(const std::vector<const btSoftBody*>& bodies) {
  std::vector<std::vector<bool>> marked;
  marked.reserve(bodies.size());
  for (const btSoftBody* body : bodies) marked.emplace_back(static_cast<std::size_t>(body->m_nodes.size()), false);

  const std::vector<Corners> triangles = read_triangles(bodies);
  const TriangleGrid grid(triangles);
  const auto mark = [&](const Corner& corner) {
    marked[static_cast<std::size_t>(corner.body)][static_cast<std::size_t>(corner.node)] = true;
  };
  for (const Corners& corners : triangles) {
    const Box box = box_of(corners);
    grid.for_each_near(box, [&](std::uint32_t other_index) {
      const Corners& other = triangles[other_index];
      if (!overlap(box, box_of(other)) || share_vertex(corners, other)) return;
      for (std::size_t i = 0; i < 3; ++i) {
        const Corner& p = corners[i];
        const Corner& q = corners[(i + 1) % 3];
        if (!pierces(p.position, q.position, other)) continue;
        mark(p);
        mark(q);
      }
    });
  }
  return marked;
}

bool is_inside_convex(const btSoftBody& convex, const btVector3& point) {
  for (int f = 0; f < convex.m_faces.size(); ++f) {
    const btSoftBody::Face& face = convex.m_faces[f];
    const btVector3& a = face.m_n[0]->m_x;
    const btVector3 outward = (face.m_n[1]->m_x - a).cross(face.m_n[2]->m_x - a);
    if (outward.dot(point - a) >= 0) return false;
  }
  return true;
}

}  // namespace softcd::demo

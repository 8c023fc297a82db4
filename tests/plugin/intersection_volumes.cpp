#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "probing.hpp"

// Compares intersection regions of closed meshes with brute force in rationals: inside vertices and the volume that
// both meshes have in common. The product reports no volumes. The test computes them from the inside vertices and the
// points of the curves alone, so a missing or wrong one changes the volume.
namespace softcd::test {
namespace {

using Rational = boost::multiprecision::cpp_rational;

struct RationalVec3 {
  Rational x, y, z;
};

/// All vertices are on a grid of this many bits. Rationals are in units of it, so that most are whole.
constexpr int kGridBits = 8;

RationalVec3 on_grid(Vec3d p) {
  const auto whole = [](double x) { return Rational(static_cast<std::int64_t>(std::ldexp(x, kGridBits))); };
  return {whole(p.x), whole(p.y), whole(p.z)};
}
RationalVec3 operator-(const RationalVec3& a, const RationalVec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
RationalVec3 cross(const RationalVec3& a, const RationalVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Rational dot(const RationalVec3& a, const RationalVec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// The plane of a triangle, with its normal.
struct Plane {
  Plane(const RationalVec3& a, const RationalVec3& b, const RationalVec3& c)
      : normal(cross(b - a, c - a)), offset(dot(normal, a)) {}
  /// Returns a number above 0 behind the plane, where its normal does not point.
  Rational depth_of(const RationalVec3& p) const { return offset - dot(normal, p); }

  RationalVec3 normal;
  Rational offset;
};

/// A tetrahedron between a triangle and a point behind it.
struct Tetrahedron {
  Tetrahedron(const RationalVec3& a, const RationalVec3& b, const RationalVec3& c, const RationalVec3& d)
      : corners{a, b, c, d}, faces{Plane(a, d, b), Plane(b, d, c), Plane(c, d, a), Plane(a, b, c)} {}

  bool is_turned() const { return faces[3].depth_of(corners[3]) <= 0; }
  bool has_inside(const RationalVec3& p) const {
    return std::all_of(faces.begin(), faces.end(), [&](const Plane& face) { return face.depth_of(p) >= 0; });
  }

  std::array<RationalVec3, 4> corners;
  std::array<Plane, 4> faces;
};

/// A mesh that is star-shaped around its centre, as a tetrahedron for each triangle.
std::vector<Tetrahedron> tetrahedra_of(const Mesh& mesh, Vec3d centre) {
  std::vector<Tetrahedron> tetrahedra;
  for (const Triangle& t : mesh.triangles) {
    tetrahedra.emplace_back(on_grid(mesh.positions[t.v[0]]), on_grid(mesh.positions[t.v[1]]),
                            on_grid(mesh.positions[t.v[2]]), on_grid(centre));
  }
  return tetrahedra;
}

/// The point where the segment from a to b is in a plane, from the heights of both over it.
RationalVec3 cut(const RationalVec3& a, const RationalVec3& b, const Rational& height_a, const Rational& height_b) {
  const Rational s = height_a / (height_a - height_b);
  return {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.z + s * (b.z - a.z)};
}

/// Returns six times the volume between the origin and the part of a tetrahedron's first face that is in another one.
Rational volume6_below(const Tetrahedron& of_triangle, const Tetrahedron& within) {
  std::vector<RationalVec3> polygon(of_triangle.corners.begin(), of_triangle.corners.end() - 1);
  for (const Plane& face : within.faces) {
    std::vector<Rational> depths;
    for (const RationalVec3& p : polygon) depths.push_back(face.depth_of(p));
    std::vector<RationalVec3> rest;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const std::size_t next = (i + 1) % polygon.size();
      if (depths[i] > 0) rest.push_back(polygon[i]);
      if ((depths[i] > 0) != (depths[next] > 0)) {
        rest.push_back(cut(polygon[i], polygon[next], depths[i], depths[next]));
      }
    }
    if (rest.empty()) return 0;
    polygon = std::move(rest);
  }
  Rational volume = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    volume += dot(polygon[0], cross(polygon[i - 1], polygon[i]));
  }
  return volume;
}

/// Returns the volume that two meshes of tetrahedra have in common: that below the parts of the surface of each that
/// are in the other.
Rational common_volume(const std::vector<Tetrahedron>& a, const std::vector<Tetrahedron>& b) {
  Rational volume = 0;
  for (const Tetrahedron& of_a : a) {
    for (const Tetrahedron& of_b : b) {
      volume += volume6_below(of_a, of_b) + volume6_below(of_b, of_a);
    }
  }
  return volume / 6;
}

/// A part of the sum that makes a volume from a polyhedron's corners: a corner, an edge there, a face at the edge.
/// W. R. Franklin, Polygon properties calculated from the vertex neighborhoods (1987).
class VolumeSum {
 public:
  /// `along` leads from the corner along an edge. `face` is a direction in the face, on its side of the edge. `inwards`
  /// leads from the face into the polyhedron.
  void add(Vec3d corner, Vec3d along, Vec3d face, Vec3d inwards) {
    const Vec3d t = unit(along);
    const Vec3d n = unit(face - dot(face, t) * t);
    sum_ += dot(corner, t) * dot(corner, n) * dot(corner, unit(inwards));
  }
  double volume() const { return -sum_ / 6; }

 private:
  static Vec3d unit(Vec3d v) { return (1 / std::sqrt(squared_norm(v))) * v; }

  double sum_ = 0;
};

/// A triangle of a closed mesh that turns counterclockwise seen from outside.
struct Face {
  Vec3d x[3];
  Vec3d inwards() const { return softcd::cross(x[2] - x[0], x[1] - x[0]); }
};

Face face_of(const SceneBody& body, const Triangle& t) {
  return {{body.x_t1[t.v[0]], body.x_t1[t.v[1]], body.x_t1[t.v[2]]}};
}

/// Returns the volume that two closed meshes have in common, from the vertices that are inside the other mesh and the
/// points at which edges pass through the other mesh.
double volume_of(const ProbedBodies& probed, const IntersectionRegions& found,
                 const std::array<std::set<std::uint32_t>, 2>& inside) {
  VolumeSum sum;
  for (std::size_t b = 0; b < 2; ++b) {
    const SceneBody& body = probed.bodies[b];
    for (const Triangle& t : body.triangles) {
      const Face face = face_of(body, t);
      for (std::size_t i = 0; i < 3; ++i) {
        if (inside[b].count(t.v[i]) == 0) continue;
        const Vec3d next = face.x[(i + 1) % 3] - face.x[i];
        const Vec3d last = face.x[(i + 2) % 3] - face.x[i];
        sum.add(face.x[i], next, last, face.inwards());
        sum.add(face.x[i], last, next, face.inwards());
      }
    }
  }
  for (const CurvePoint& point : found.points) {
    const std::size_t b = point.edge_body == probed.ids[0] ? 0 : 1;
    const SceneBody& body = probed.bodies[b];
    const SceneBody& pierced = probed.bodies[1 - b];
    const Face through = face_of(pierced, pierced.triangles[point.triangle]);
    Vec3d along = body.x_t1[point.edge[1]] - body.x_t1[point.edge[0]];
    if (dot(along, through.inwards()) < 0) along = -1.0 * along;
    std::vector<Face> sides;
    for (const Triangle& t : body.triangles) {
      const auto has = [&t](std::uint32_t v) { return t.v[0] == v || t.v[1] == v || t.v[2] == v; };
      if (has(point.edge[0]) && has(point.edge[1])) sides.push_back(face_of(body, t));
    }
    for (const Face& side : sides) {
      // A direction into the face from the edge: the face's corner that is not at the edge is among these.
      Vec3d into{0, 0, 0};
      for (const Vec3d& x : side.x) into = into + (x - point.position);
      into = into - (dot(into, along) / squared_norm(along)) * along;
      sum.add(point.position, along, into, side.inwards());
      Vec3d common = softcd::cross(side.inwards(), through.inwards());
      if (dot(common, into) < 0) common = -1.0 * common;
      sum.add(point.position, common, along, side.inwards());
      const Vec3d normal = through.inwards();
      const Vec3d in_plane = side.inwards() - (dot(side.inwards(), normal) / squared_norm(normal)) * normal;
      sum.add(point.position, common, in_plane, normal);
    }
  }
  return sum.volume();
}

/// Returns a mesh around `centre` that is star-shaped there: an octahedron or an icosahedron with rough vertices.
Mesh star(Random& random, bool is_fine, double radius, Vec3d centre) {
  while (true) {
    Mesh mesh;
    if (is_fine) {
      mesh = outward_ball(0, radius);
    } else {
      mesh.positions = {{radius, 0, 0},  {-radius, 0, 0}, {0, radius, 0},
                        {0, -radius, 0}, {0, 0, radius},  {0, 0, -radius}};
      for (std::uint32_t i = 0; i < 8; ++i) {
        const std::uint32_t x = i & 1U;
        const std::uint32_t y = 2 + (i >> 1U & 1U);
        const std::uint32_t z = 4 + (i >> 2U & 1U);
        const bool is_mirrored = (x + y + z) % 2 != 0;
        mesh.triangles.push_back(is_mirrored ? Triangle{{x, z, y}} : Triangle{{x, y, z}});
      }
    }
    for (Vec3d& x : mesh.positions) x = random.uniform(0.6, 1.4) * x + 0.3 * radius * random.in_box(1.0) + centre;
    snap_to_grid(mesh.positions, kGridBits);
    bool is_star = true;
    for (const Tetrahedron& t : tetrahedra_of(mesh, centre)) is_star &= !t.is_turned();
    if (is_star) return mesh;
  }
}

std::set<std::uint32_t> inside_vertices(const IntersectionRegions& found, BodyId body) {
  std::set<std::uint32_t> vertices;
  for (const IntersectionRegion& region : found.regions) {
    if (region.body != body || !region.is_inside) continue;
    for (std::uint32_t i = 0; i < region.vertex_count; ++i) {
      vertices.insert(found.vertices[region.first_vertex + i].vertex);
    }
  }
  return vertices;
}

TEST(IntersectionVolumes, of_random_pairs_are_those_of_brute_force_in_rationals) {
  constexpr int kPairs = 1000;
  Random random(21);
  int crossing = 0;
  for (int pair = 0; pair < kPairs; ++pair) {
    SCOPED_TRACE(pair);
    const bool is_fine = pair % 50 == 0;
    Positions3 centres = {{0, 0, 0}, random.in_box(0.8)};
    snap_to_grid(centres, kGridBits);
    const Mesh meshes[2] = {star(random, is_fine, 1, centres[0]),
                            star(random, is_fine, random.uniform(0.3, 1.2), centres[1])};
    ProbedBodies probed({still(meshes[0], {}), still(meshes[1], {})});
    const IntersectionRegions found = probed.probe.intersection_regions({probed.ids[0], probed.ids[1]});
    const std::array<std::set<std::uint32_t>, 2> inside = {inside_vertices(found, probed.ids[0]),
                                                           inside_vertices(found, probed.ids[1])};
    const std::vector<Tetrahedron> tetrahedra[2] = {tetrahedra_of(meshes[0], centres[0]),
                                                    tetrahedra_of(meshes[1], centres[1])};
    for (std::size_t b = 0; b < 2; ++b) {
      for (std::uint32_t v = 0; v < meshes[b].positions.size(); ++v) {
        const RationalVec3 x = on_grid(meshes[b].positions[v]);
        const bool is_inside = std::any_of(tetrahedra[1 - b].begin(), tetrahedra[1 - b].end(),
                                           [&](const Tetrahedron& t) { return t.has_inside(x); });
        ASSERT_EQ(inside[b].count(v) > 0, is_inside) << "body " << b << ", vertex " << v;
      }
    }
    const Rational volume = common_volume(tetrahedra[0], tetrahedra[1]);
    ASSERT_NEAR(volume_of(probed, found, inside), std::ldexp(static_cast<double>(volume), -3 * kGridBits), 1e-9);
    crossing += found.curves.empty() ? 0 : 1;
  }
  EXPECT_GT(crossing, kPairs * 8 / 10);
}

}  // namespace
}  // namespace softcd::test

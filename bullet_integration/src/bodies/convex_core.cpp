#include "bodies/convex_core.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "BulletCollision/CollisionShapes/btConeShape.h"
#include "BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btCylinderShape.h"
#include "BulletCollision/CollisionShapes/btPolyhedralConvexShape.h"
#include "BulletCollision/CollisionShapes/btStridingMeshInterface.h"
#include "LinearMath/btConvexHullComputer.h"
#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

/// Points closer than this share of the core's extent count as one point: only rounding separates them.
constexpr btScalar kSamePoint = btScalar(1e-5);

class MeshCorners : public btInternalTriangleIndexCallback {
 public:
  explicit MeshCorners(std::vector<btVector3>& points) : points_(points) {}
  void internalProcessTriangleIndex(btVector3* triangle, int /*part*/, int /*index*/) override {
    points_.insert(points_.end(), triangle, triangle + 3);
  }

 private:
  std::vector<btVector3>& points_;
};

using Directions = std::vector<btVector3>;

Directions around(int axis, const std::vector<btScalar>& latitudes) {
  Directions directions;
  for (const btScalar latitude : latitudes) {
    for (int meridian = 0; meridian < ConvexCore::kCircleCorners; ++meridian) {
      const btScalar longitude = SIMD_2_PI * btScalar(meridian) / ConvexCore::kCircleCorners;
      btVector3 direction(0, 0, 0);
      direction[axis] = btSin(latitude);
      direction[(axis + 1) % 3] = btCos(latitude) * btCos(longitude);
      direction[(axis + 2) % 3] = btCos(latitude) * btSin(longitude);
      directions.push_back(direction);
    }
  }
  return directions;
}

Directions all_around() {
  constexpr int kParallels = ConvexCore::kCircleCorners / 2;
  std::vector<btScalar> latitudes;
  for (int i = 0; i <= kParallels; ++i) latitudes.push_back(SIMD_PI * (btScalar(i) / kParallels - btScalar(0.5)));
  return around(1, latitudes);
}

/// Returns the directions of the rims of cylinders and cones, and of a cone's tip.
const Directions& towards_rims(int axis) {
  static const auto make = [](int of) { return around(of, {-SIMD_PI / 4, SIMD_PI / 4, SIMD_HALF_PI}); };
  static const std::array<Directions, 3> made = {make(0), make(1), make(2)};
  return made[static_cast<std::size_t>(axis)];
}

Directions towards_corners() {
  Directions directions;
  for (int i = 0; i < 8; ++i) {
    directions.emplace_back(btScalar((i & 1) != 0 ? 1 : -1), btScalar((i & 2) != 0 ? 1 : -1),
                            btScalar((i & 4) != 0 ? 1 : -1));
  }
  return directions;
}

/// Returns directions whose farthest points represent the shape.
const Directions& directions_of(const btConvexShape& shape) {
  static const Directions corners = towards_corners();
  static const Directions all = all_around();
  switch (shape.getShapeType()) {
    case BOX_SHAPE_PROXYTYPE:
    case SPHERE_SHAPE_PROXYTYPE:
    case CAPSULE_SHAPE_PROXYTYPE:
      return corners;
    case CYLINDER_SHAPE_PROXYTYPE:
      return towards_rims(static_cast<const btCylinderShape&>(shape).getUpAxis());
    case CONE_SHAPE_PROXYTYPE:
      return towards_rims(static_cast<const btConeShape&>(shape).getConeUpIndex());
    default:
      return all;
  }
}

/// Returns the core's points. A box's own vertices include its margin, so they are not used.
std::vector<btVector3> points_of(const btConvexShape& shape) {
  std::vector<btVector3> points;
  if (shape.getShapeType() == CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE) {
    const btStridingMeshInterface& mesh = *static_cast<const btConvexTriangleMeshShape&>(shape).getMeshInterface();
    const btVector3 everything(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
    MeshCorners corners(points);
    mesh.InternalProcessAllTriangles(&corners, -everything, everything);
  } else if (shape.isPolyhedral() && shape.getShapeType() != BOX_SHAPE_PROXYTYPE) {
    const auto& polyhedron = static_cast<const btPolyhedralConvexShape&>(shape);
    points.resize(static_cast<std::size_t>(polyhedron.getNumVertices()));
    for (int i = 0; i < polyhedron.getNumVertices(); ++i) polyhedron.getVertex(i, points[static_cast<std::size_t>(i)]);
  } else {
    for (const btVector3& direction : directions_of(shape)) {
      points.push_back(shape.localGetSupportVertexWithoutMarginNonVirtual(direction));
    }
  }
  return points;
}

std::vector<btVector3> distinct(const std::vector<btVector3>& points) {
  Bounds bounds = {points[0], points[0]};
  for (const btVector3& point : points) bounds.add(point);
  const btScalar tolerance = kSamePoint * kSamePoint * (bounds.high - bounds.low).length2();
  std::vector<btVector3> kept;
  for (const btVector3& point : points) {
    const bool is_known = std::any_of(kept.begin(), kept.end(),
                                      [&](const btVector3& other) { return point.distance2(other) <= tolerance; });
    if (!is_known) kept.push_back(point);
  }
  return kept;
}

}  // namespace

bool ConvexCore::read(const btConvexShape& shape) {
  std::vector<btVector3> points = points_of(shape);
  if (are_equal(points, points_)) return false;
  points_ = std::move(points);
  build();
  return true;
}

void ConvexCore::build() {
  clear();
  edges_.clear();
  if (points_.empty()) return;
  const std::vector<btVector3> points = distinct(points_);
  btConvexHullComputer hull;
  hull.compute(&points[0][0], sizeof(btVector3), static_cast<int>(points.size()), 0, 0);
  for (int i = 0; i < hull.original_vertex_index.size(); ++i) {
    vertices_.push_back(points[static_cast<std::size_t>(hull.original_vertex_index[i])]);
  }
  const auto add_edge = [this](const btConvexHullComputer::Edge& edge) {
    edges_.emplace_back(std::minmax<std::uint32_t>(edge.getSourceVertex(), edge.getTargetVertex()));
  };
  for (int i = 0; i < hull.edges.size(); ++i) add_edge(hull.edges[i]);
  std::sort(edges_.begin(), edges_.end());
  edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  for (int i = 0; i < hull.faces.size(); ++i) {
    const btConvexHullComputer::Edge* const first = &hull.edges[hull.faces[i]];
    const auto corner = static_cast<std::uint32_t>(first->getSourceVertex());
    for (const auto* edge = first->getNextEdgeOfFace(); edge->getTargetVertex() != first->getSourceVertex();
         edge = edge->getNextEdgeOfFace()) {
      triangles_.push_back({{corner, static_cast<std::uint32_t>(edge->getSourceVertex()),
                             static_cast<std::uint32_t>(edge->getTargetVertex())}});
    }
  }
  if (!triangles_.empty()) return;
  for (const auto& [low, high] : edges_) triangles_.push_back({{low, high, high}});
  if (edges_.empty()) triangles_.push_back({{0, 0, 0}});
}

bool ConvexCore::is_edge(std::uint32_t low, std::uint32_t high) const {
  return std::binary_search(edges_.begin(), edges_.end(), std::pair(low, high));
}

bool ConvexCore::is_farthest(const btVector3& point, const btVector3& normal, double time) const {
  constexpr btScalar kStillFarthest = btScalar(0.01);
  constexpr btScalar kSamePlace = 4 * btScalar(std::numeric_limits<float>::epsilon());
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const btVector3 start = to_bullet(x_t0()[i]);
    const btVector3 end = to_bullet(x_t1()[i]);
    const btVector3 away = lerp(start, end, btScalar(time)) - point;
    const btScalar rounding = kSamePlace * (start.length() + end.length());
    if (away.dot(normal) > kStillFarthest * away.length() + rounding) return false;
  }
  return true;
}

ConvexCore::Depth ConvexCore::depth_of(Vec3d point) const {
  Vec3d middle{0, 0, 0};
  for (const Vec3d& corner : x_t0()) middle = middle + (1.0 / static_cast<double>(x_t0().size())) * corner;
  Depth nearest = {false, std::numeric_limits<double>::infinity(), {0, 0, 0}};
  for (const Triangle& triangle : triangles_) {
    const Vec3d corner = x_t0()[triangle.v[0]];
    const Vec3d across = cross(x_t0()[triangle.v[1]] - corner, x_t0()[triangle.v[2]] - corner);
    const double twice_area = std::sqrt(squared_norm(across));
    if (!(twice_area > 0)) continue;
    const double height = dot(across, corner - middle);
    // A flat core has no inside.
    if (!(std::abs(height) > 1e-9 * std::pow(twice_area, 1.5))) return {};
    const Vec3d normal = ((height < 0 ? -1.0 : 1.0) / twice_area) * across;
    const double depth = dot(normal, corner - point);
    if (!(depth > 0)) return {};
    if (depth < nearest.depth) nearest = {true, depth, normal};
  }
  return nearest.is_inside ? nearest : Depth{};
}

bool ConvexCore::is_pierced(const btVector3& point, const btVector3& normal) const {
  double low = 0;
  double high = 0;
  for (const Vec3d& corner : x_t0()) {
    const double along = dot(to_doubles(normal), corner - to_doubles(point));
    low = std::min(low, along);
    high = std::max(high, along);
  }
  return -low < high && depth_of(to_doubles(point)).is_inside;
}

}  // namespace softcd::bullet

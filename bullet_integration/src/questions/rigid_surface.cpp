#include "questions/rigid_surface.hpp"

#include <cmath>
#include <limits>

#include "BulletCollision/CollisionShapes/btConcaveShape.h"

namespace softcd::bullet {

RigidSurface::RigidSurface(const btConvexShape& shape, const btTransform& place)
    : is_convex_(true), margin_(shape.getMarginNonVirtual()) {
  core_.read(shape);
  core_.place({place, place});
}

RigidSurface::RigidSurface(const btConcaveShape& shape, const btTransform& place, const Bounds& box)
    : is_convex_(false), margin_(shape.getMargin()) {
  mesh_.read(shape, {box_in_shape(box.grown(margin_), {place, place})});
  mesh_.place({place, place});
}

RigidSurface::Depth RigidSurface::depth_of(Vec3d point) const {
  if (!is_convex_ || x().empty()) return {};
  Vec3d middle{0, 0, 0};
  for (const Vec3d& corner : x()) middle = middle + (1.0 / static_cast<double>(x().size())) * corner;
  Depth nearest = {false, std::numeric_limits<double>::infinity(), {0, 0, 0}};
  for (const Triangle& triangle : triangles()) {
    const Vec3d corner = x()[triangle.v[0]];
    const Vec3d across = cross(x()[triangle.v[1]] - corner, x()[triangle.v[2]] - corner);
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

std::vector<RigidSurface> rigid_surfaces(const btCollisionObject& object, const Bounds& box) {
  std::vector<RigidSurface> surfaces;
  const auto add = [&](const btCollisionShape& shape, const btTransform& place) {
    if (shape.isConvex()) {
      surfaces.emplace_back(static_cast<const btConvexShape&>(shape), place);
    } else if (shape.isConcave() && shape.getShapeType() != STATIC_PLANE_PROXYTYPE) {
      surfaces.emplace_back(static_cast<const btConcaveShape&>(shape), place, box);
    }
    return false;
  };
  any_simple_shape(*object.getCollisionShape(), object.getWorldTransform(), add);
  return surfaces;
}

}  // namespace softcd::bullet

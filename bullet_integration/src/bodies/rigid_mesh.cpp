#include "bodies/rigid_mesh.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "BulletCollision/CollisionShapes/btConcaveShape.h"

namespace softcd::bullet {
namespace {

/// Share of a box's size by which its region is larger on each side, so that moving bodies stay in it for some steps.
constexpr btScalar kRegionGrowth = btScalar(0.25);

bool contains(const Bounds& outer, const Bounds& inner) {
  for (int axis = 0; axis < 3; ++axis) {
    if (inner.low[axis] < outer.low[axis] || inner.high[axis] > outer.high[axis]) return false;
  }
  return true;
}

class Corners : public btTriangleCallback {
 public:
  void processTriangle(btVector3* triangle, int /*part*/, int /*index*/) override {
    corners.insert(corners.end(), triangle, triangle + 3);
  }

  std::vector<btVector3> corners;
};

auto coordinates(const btVector3& v) {
  return std::tuple(v.x(), v.y(), v.z());
}

}  // namespace

bool RigidMesh::covers(const Bounds& box) const {
  return std::any_of(regions_.begin(), regions_.end(), [&](const Bounds& region) { return contains(region, box); });
}

bool RigidMesh::read(const btConcaveShape& shape, const std::vector<Bounds>& boxes) {
  const auto is_covered = [this](const Bounds& box) { return covers(box); };
  if (std::exchange(is_whole_, false) || !std::all_of(boxes.begin(), boxes.end(), is_covered)) {
    regions_.clear();
    for (const Bounds& box : boxes) {
      regions_.push_back(box.grown((box.high - box.low) * kRegionGrowth));
    }
  }
  return read_regions(shape);
}

bool RigidMesh::read_whole(const btConcaveShape& shape) {
  regions_ = {bounds_of(shape, btTransform::getIdentity())};
  is_whole_ = true;
  return read_regions(shape);
}

bool RigidMesh::read_regions(const btConcaveShape& shape) {
  Corners found;
  for (const Bounds& region : regions_) shape.processAllTriangles(&found, region.low, region.high);
  if (are_equal(found.corners, corners_)) return false;
  corners_ = std::move(found.corners);
  weld();
  return true;
}

// Merges corners at the same place into one vertex. A triangle that several regions have found is kept once.
void RigidMesh::weld() {
  clear();
  std::map<decltype(coordinates(btVector3())), std::uint32_t> places;
  for (std::size_t corner = 0; corner < corners_.size(); corner += 3) {
    Triangle triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      const btVector3& position = corners_[corner + i];
      const auto [place, is_new] = places.try_emplace(coordinates(position), vertex_count());
      if (is_new) vertices_.push_back(position);
      triangle.v[i] = place->second;
    }
    triangles_.push_back(triangle);
  }
  const auto indices = [](const Triangle& t) { return std::tuple(t.v[0], t.v[1], t.v[2]); };
  std::sort(triangles_.begin(), triangles_.end(),
            [&](const Triangle& a, const Triangle& b) { return indices(a) < indices(b); });
  triangles_.erase(std::unique(triangles_.begin(), triangles_.end(),
                               [&](const Triangle& a, const Triangle& b) { return indices(a) == indices(b); }),
                   triangles_.end());
}

}  // namespace softcd::bullet

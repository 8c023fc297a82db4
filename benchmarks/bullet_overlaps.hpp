#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

/// What btCollisionWorld::contactPairTest says of a btBvhTriangleMeshShape, without a margin, and a convex shape: its
/// hierarchy, GJK with each triangle whose box meets the shape's, in Bullet's float, question by question on one
/// thread. Bullet has no such test of two such meshes.
class BulletOverlaps {
 public:
  /// `unit` is a length that is 1 for Bullet, about as large as the shapes: its tolerances are lengths, and of hulls
  /// about a fiftieth as large it missed a fifth of the triangles. Keeps a reference to `triangles`.
  BulletOverlaps(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x, double unit);
  ~BulletOverlaps();

  /// How many triangles have contacts with a btCapsuleShape, or with a btConvexHullShape whose margin is the hull's
  /// radius, in all.
  std::size_t count(Span<const ProbeCapsule> capsules) const;
  std::size_t count(Span<const ProbeHull> hulls) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace softcd::benchmarks

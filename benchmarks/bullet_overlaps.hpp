#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

/// The results of btCollisionWorld::contactPairTest for a btBvhTriangleMeshShape without a margin and a convex shape.
/// Bullet searches its hierarchy, then runs GJK in float for each triangle whose box meets the shape's box, one
/// question after the other on one thread. Bullet has no such test of two meshes.
class BulletOverlaps {
 public:
  /// `unit` is a length that becomes 1 for Bullet; it should be about the size of the shapes. Bullet's tolerances are
  /// lengths: with hulls of about a fiftieth of the unit it missed a fifth of the triangles. Keeps a reference to
  /// `triangles`.
  BulletOverlaps(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x, double unit);
  ~BulletOverlaps();

  /// Return the total number of triangles that have contacts with a btCapsuleShape, or with a btConvexHullShape whose
  /// margin is the hull's radius.
  std::size_t count(Span<const ProbeCapsule> capsules) const;
  std::size_t count(Span<const ProbeHull> hulls) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace softcd::benchmarks

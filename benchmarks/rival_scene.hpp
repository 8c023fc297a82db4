#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

/// Another library's results for one mesh.
class RivalScene {
 public:
  RivalScene() = default;
  RivalScene(const RivalScene&) = delete;
  RivalScene& operator=(const RivalScene&) = delete;
  virtual ~RivalScene() = default;

  virtual const char* name() const = 0;
  /// Builds the structure for the queries.
  virtual void build() = 0;
  /// Returns the number of rays that meet a triangle. Each ray is traced to its first hit.
  virtual std::size_t count_hits(const std::vector<Ray>& rays) const = 0;
  /// Returns whether these counts are exact, except for a few in a thousand.
  virtual bool counts_exactly() const { return true; }
  /// Returns the sum of the points' distances from the mesh; negative where the library has no such query.
  virtual double sum_distances(const std::vector<ProbePoint>& points) const = 0;
};

#ifdef SOFTCD_BENCH_HAS_BULLET
/// Makes a scene for btSoftBody::rayTest, ray by ray on one thread, as Bullet's worlds call it. The face tree is
/// softcd's, because Bullet takes time quadratic in the faces to build its own.
std::unique_ptr<RivalScene> make_bullet_scene(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x);

/// The time of rays in a world of three cloths, each traced to the first hit.
struct SingleRayTime {
  std::string world;
  double margin;             ///< of the cloths
  double first_us, next_us;  ///< medians over the steps: first ray after a step, and each later one
  double batch_us;           ///< each ray of a batch by WorldProbe, with reading all bodies
  std::size_t rays, hits;    ///< of the single rays
  std::size_t batch_hits;    ///< of as many rays in batches
};
/// Measures rayTest of Bullet's classic world and of softcd's, and batches in both.
std::vector<SingleRayTime> time_single_rays(int steps);
#endif
#ifdef SOFTCD_BENCH_HAS_EMBREE
/// Makes a scene for Embree's rtcIntersect1 and rtcPointQuery, in float, on all threads. It is in robust mode, so that
/// rays do not slip through edges.
std::unique_ptr<RivalScene> make_embree_scene(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x);
#endif

}  // namespace softcd::benchmarks

#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

/// Somebody else's answers about one mesh.
class RivalScene {
 public:
  RivalScene() = default;
  RivalScene(const RivalScene&) = delete;
  RivalScene& operator=(const RivalScene&) = delete;
  virtual ~RivalScene() = default;

  virtual const char* name() const = 0;
  /// Builds what it answers from.
  virtual void build() = 0;
  /// How many of the rays meet a triangle, each looked for to the first.
  virtual std::size_t count_hits(const std::vector<Ray>& rays) const = 0;
  /// Whether these are those of exact arithmetic, but for a few in a thousand.
  virtual bool counts_exactly() const { return true; }
  /// The sum of the points' distances from the mesh; negative where it does not tell.
  virtual double sum_distances(const std::vector<ProbePoint>& points) const = 0;
};

#ifdef SOFTCD_BENCH_HAS_BULLET
/// btSoftBody::rayTest, ray by ray on one thread, as Bullet's worlds call it. The face tree is softcd's, as Bullet
/// takes time quadratic in the faces to build its own.
std::unique_ptr<RivalScene> make_bullet_scene(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x);

/// Rays that a world of three cloths was asked about one at a time, to the first hit.
struct SingleRayTime {
  std::string world;
  double margin;             ///< of the cloths
  double first_us, next_us;  ///< medians of the steps: of the first ray after a step, of each of those behind it
  std::size_t rays, hits;
};
/// With rayTest of Bullet's classic world and of softcd's.
std::vector<SingleRayTime> time_single_rays(int steps);
#endif
#ifdef SOFTCD_BENCH_HAS_EMBREE
/// Embree's rtcIntersect1 and rtcPointQuery, in float, on all threads; robust, so that rays do not slip through edges.
std::unique_ptr<RivalScene> make_embree_scene(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x);
#endif

}  // namespace softcd::benchmarks

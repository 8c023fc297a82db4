#include "every_pair.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "softcd/core/parallel.hpp"
#include "softcd/math/closest_triangles.hpp"
#include "softcd/math/intersection.hpp"

namespace softcd::benchmarks {
namespace {

struct Corners {
  Vec3f x[3];

  Corners(const Triangle& t, const std::vector<Vec3f>& positions)
      : x{positions[t.v[0]], positions[t.v[1]], positions[t.v[2]]} {}
};

/// The intervals of a triangle along each axis.
struct Box {
  Vec3f lo, hi;

  explicit Box(const Corners& t)
      : lo{std::min({t.x[0].x, t.x[1].x, t.x[2].x}), std::min({t.x[0].y, t.x[1].y, t.x[2].y}),
           std::min({t.x[0].z, t.x[1].z, t.x[2].z})},
        hi{std::max({t.x[0].x, t.x[1].x, t.x[2].x}), std::max({t.x[0].y, t.x[1].y, t.x[2].y}),
           std::max({t.x[0].z, t.x[1].z, t.x[2].z})} {}

  double squared_gap(const Box& other) const {
    double squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double gap = std::max({double(lo[axis]) - other.hi[axis], double(other.lo[axis]) - hi[axis], 0.0});
      squared += gap * gap;
    }
    return squared;
  }
};

/// Calls `add` for every triangle of `mesh` with the result for the triangles before, from `none` on. `join` combines
/// the results of threads.
template <class T, class Add, class Join>
T fold_triangles(const MeshView& mesh, T none, const Add& add, const Join& join) {
  return parallel::reduce(
      mesh.triangles.size(), 1, none,
      [&](std::size_t begin, std::size_t end, T result) {
        for (std::size_t i = begin; i < end; ++i) result = add(i, result);
        return result;
      },
      join);
}

}  // namespace

double distance_by_every_pair(const MeshView& a, const MeshView& b) {
  const auto nearer_of = [&](std::size_t i, double nearest) {
    const Corners corners(b.triangles[i], b.x);
    const Box box(corners);
    for (const Triangle& t : a.triangles) {
      const Corners others(t, a.x);
      if (Box(others).squared_gap(box) >= nearest) continue;
      nearest = std::min(nearest, closest_points_of_triangles(others.x, corners.x).squared_distance);
    }
    return nearest;
  };
  const auto smaller_of = [](double p, double q) { return std::min(p, q); };
  return std::sqrt(fold_triangles(b, std::numeric_limits<double>::infinity(), nearer_of, smaller_of));
}

std::size_t intersections_by_every_pair(const MeshView& a, const MeshView& b) {
  const auto with_intersections_of = [&](std::size_t i, std::size_t found) {
    const Corners corners(b.triangles[i], b.x);
    return found +
           static_cast<std::size_t>(std::count_if(a.triangles.begin(), a.triangles.end(), [&](const Triangle& t) {
             return do_intersect(Corners(t, a.x).x, corners.x);
           }));
  };
  return fold_triangles(b, std::size_t{0}, with_intersections_of, std::plus<>());
}

std::size_t intersections_after_by_every_pair(const MeshView& mesh, const ProbeChange& change) {
  std::vector<Vec3f> x = mesh.x;
  for (const Vec3d& vertex : change.new_vertices) x.push_back(vec3_cast<float>(vertex));
  const auto with_intersections_of = [&](std::size_t i, std::size_t found) {
    const Triangle& triangle = mesh.triangles[i];
    if (std::find(change.removed.begin(), change.removed.end(), i) != change.removed.end()) return found;
    const Corners corners(triangle, x);
    return found +
           static_cast<std::size_t>(std::count_if(change.added.begin(), change.added.end(), [&](const Triangle& t) {
             return do_intersect(Corners(t, x).x, corners.x, shared_corners(t, triangle));
           }));
  };
  return fold_triangles(mesh, std::size_t{0}, with_intersections_of, std::plus<>());
}

}  // namespace softcd::benchmarks

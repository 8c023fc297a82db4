#pragma once

#include <cstdint>
#include <cstring>

#include "softcd/core/host_device.hpp"
#include "softcd/math/closest_triangles.hpp"
#include "softcd/stages/body_pairs.hpp"
#include "softcd/stages/closest_points.hpp"

/// The nearest points of bodies. Each item searches the triangle that is nearest to its own, no further away than the
/// best found by then. Of the items that found the least distance the triangles decide, so that the order of the
/// searches does not matter.
namespace softcd {

/// Positive doubles and their bits have the same order.
SOFTCD_HD inline std::uint64_t bits_of(double x) {
  std::uint64_t bits = 0;
  memcpy(&bits, &x, sizeof(bits));
  return bits;
}
SOFTCD_HD inline double double_of(std::uint64_t bits) {
  double x = 0;
  memcpy(&x, &bits, sizeof(x));
  return x;
}

SOFTCD_HD inline double gap(double lo_a, double hi_a, double lo_b, double hi_b) {
  return larger(larger(lo_a - hi_b, lo_b - hi_a), 0.0);
}

SOFTCD_HD inline double squared_distance(const Box& a, const Box& b) {
  const Vec3d a_lo = vec3_cast<double>(a.lo);
  const Vec3d a_hi = vec3_cast<double>(a.hi);
  const Vec3d b_lo = vec3_cast<double>(b.lo);
  const Vec3d b_hi = vec3_cast<double>(b.hi);
  return squared_norm(Vec3d{gap(a_lo.x, a_hi.x, b_lo.x, b_hi.x), gap(a_lo.y, a_hi.y, b_lo.y, b_hi.y),
                            gap(a_lo.z, a_hi.z, b_lo.z, b_hi.z)});
}

/// The triangle nearest to an item's: its place and number. Of several, the one with the lowest number.
struct NearestTriangle {
  double squared_distance;
  std::uint32_t place;
  std::uint32_t triangle;  ///< kNoIndex: none

  SOFTCD_HD bool is_before(const NearestTriangle& other) const {
    return squared_distance < other.squared_distance ||
           (squared_distance == other.squared_distance && triangle < other.triangle);
  }
};

/// Skips boxes as NearestVisitor does.
class NearestTriangleVisitor {
 public:
  using Key = double;

  /// `least` is the bits of the least squared distance known for the question.
  SOFTCD_HD NearestTriangleVisitor(const ProbedSceneView& scene, const BodiesQuestion& question, const BvhLeaf& own,
                                   std::uint64_t* least)
      : scene_(scene), question_(question), own_(own), box_(box_of(own.x)), least_(least) {}

  SOFTCD_HD bool enters(const Box& box, double& key) const {
    key = squared_distance(box, box_);
    return still_enters(key);
  }
  SOFTCD_HD bool still_enters(double key) const { return key <= reach_of(double_of(load(least_)), scene_); }
  SOFTCD_HD void visit(const BvhLeaf& other, std::uint32_t place) {
    if (!scene_.is_asked(other) || other.body == own_.body || !are_asked_together(question_, own_, other)) return;
    if (!still_enters(squared_distance(box_of(other.x), box_))) return;
    const NearestTriangle nearest = {closest_points_of_triangles(own_.x, other.x).squared_distance, place,
                                     other.triangle};
    if (best_.triangle != kNoIndex && !nearest.is_before(best_)) return;
    best_ = nearest;
    lower(least_, bits_of(nearest.squared_distance));
  }

  SOFTCD_HD const NearestTriangle& best() const { return best_; }

 private:
  const ProbedSceneView& scene_;
  const BodiesQuestion& question_;
  const BvhLeaf& own_;
  Box box_;
  std::uint64_t* least_;
  NearestTriangle best_{0.0, kNoIndex, kNoIndex};
};

/// The least squared distance of each question, and the two triangles that are chosen.
struct LeastDistance {
  std::uint64_t bits;  ///< of the squared distance
  std::uint64_t item;  ///< the first that found it
};

struct ClearLeastDistance {
  LeastDistance* least;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    constexpr std::uint64_t kInfinity = 0x7FF0000000000000ULL;
    least[i] = {kInfinity, ~std::uint64_t{0}};
  }
};

struct FindNearestTriangle {
  BodiesQuestions asked;
  LeastDistance* least;
  NearestTriangle* nearest;

  SOFTCD_HD void operator()(std::uint32_t item) const {
    const std::uint32_t q = asked.question_of(item);
    const BodiesQuestion& question = asked.questions[q];
    nearest[item] = {0.0, kNoIndex, kNoIndex};
    const BvhLeaf own = asked.triangle_of(item, question);
    if (own.triangle == kNoIndex) return;
    NearestTriangleVisitor visitor(asked.scene, question, own, &least[q].bits);
    visit_leaves(asked.scene.bvh, visitor, other_bodies(question, own));
    nearest[item] = visitor.best();
  }
};

struct ChooseNearestItem {
  BodiesQuestions asked;
  LeastDistance* least;
  const NearestTriangle* nearest;

  SOFTCD_HD void operator()(std::uint32_t item) const {
    LeastDistance& chosen = least[asked.question_of(item)];
    if (nearest[item].triangle == kNoIndex || bits_of(nearest[item].squared_distance) != chosen.bits) return;
    lower(&chosen.item, item);
  }
};

struct DescribeDistance {
  BodiesQuestions asked;
  const LeastDistance* least;
  const NearestTriangle* nearest;
  BodyDistance* distances;

  SOFTCD_HD void operator()(std::uint32_t q) const {
    BodyDistance result;
    if (least[q].item != ~std::uint64_t{0}) describe(q, result);
    distances[q] = result;
  }

 private:
  SOFTCD_HD void describe(std::uint32_t q, BodyDistance& result) const {
    const auto item = static_cast<std::uint32_t>(least[q].item);
    const ProbedSceneView& scene = asked.scene;
    const BvhLeaf own = asked.triangle_of(item, asked.questions[q]);
    const BvhLeaf& other = scene.bvh.leaves[nearest[item].place];
    const ClosestOnTriangles closest = closest_points_of_triangles(own.x, other.x);
    result.body_a = {scene.bodies[own.body].id};
    result.body_b = {scene.bodies[other.body].id};
    result.triangle_a = own.triangle - scene.bodies[own.body].first_triangle;
    result.triangle_b = other.triangle - scene.bodies[other.body].first_triangle;
    const bool do_intersect = closest.squared_distance == 0.0;
    result.distance = do_intersect ? 0.0 : length(closest.offset);
    Vec3d position{0, 0, 0};
    for (int corner = 0; corner < 3; ++corner) {
      result.weights_a[corner] = static_cast<float>(closest.weights_a[corner]);
      result.weights_b[corner] = static_cast<float>(closest.weights_b[corner]);
      position = position + closest.weights_a[corner] * vec3_cast<double>(own.x[corner]);
    }
    result.position_a = scene.origin + position;
    result.position_b = scene.origin + (position - closest.offset);
  }
};

}  // namespace softcd

#pragma once

#include <cstdint>
#include <functional>

#include "softcd/core/spatial_query.hpp"
#include "softcd/math/box.hpp"
#include "softcd/stages/body_pairs.hpp"
#include "softcd/stages/hull_questions.hpp"
#include "softcd/stages/mesh_changes.hpp"
#include "softcd/stages/probed_scene.hpp"

namespace softcd {

/// Input of spatial queries, beside the detector's scene.
struct ProbedScene {
  Span<const ProbedBody> bodies;  ///< all of the scene's, in its order
  Vec3d origin;                   ///< the scene's positions are relative to it
  Box bounds;                     ///< of all positions that are finite, at that end
  bool at_t0;                     ///< else at t1
  bool covers_rounding;           ///< some positions are no floats, and count as they were given
  std::uint64_t revision;         ///< changes with anything of the scene
};

/// Answers of one backend; see softcd/probe.hpp. They stay valid until the next question with the same memory.
class SpatialQueries {
 public:
  virtual ~SpatialQueries() = default;

  virtual Span<const RayHit> first_hits(Span<const Ray> rays) = 0;
  virtual AnswerLists<RayHit> all_hits(Span<const Ray> rays) = 0;
  virtual Span<const ClosestPoint> closest_points(Span<const ProbePoint> points) = 0;
  virtual AnswerLists<TriangleOverlap> overlaps(Span<const ProbeSphere> spheres) = 0;
  virtual AnswerLists<TriangleOverlap> overlaps(Span<const ProbeCapsule> capsules) = 0;
  virtual AnswerLists<TriangleOverlap> overlaps(Span<const ProbeBox> boxes) = 0;
  virtual AnswerLists<TriangleOverlap> overlaps(Span<const ProbeOrientedBox> boxes) = 0;
  virtual AnswerLists<TriangleOverlap> overlaps(const HullQuestions& questions) = 0;
  /// `item_count` is the number of items of all questions.
  virtual Span<const BodyDistance> distances(Span<const BodiesQuestion> questions, std::uint64_t item_count) = 0;
  virtual AnswerLists<TriangleIntersection> intersections(Span<const BodiesQuestion> questions,
                                                          std::uint64_t item_count) = 0;
  virtual bool has_intersections(Span<const BodiesQuestion> questions, std::uint64_t item_count) = 0;
  virtual AnswerLists<ChangeIntersection> intersections_after(const ChangeQuestions& questions) = 0;
};

/// Asks questions. The detector calls it again if memory did not suffice at first.
using Questions = std::function<void(SpatialQueries&)>;

}  // namespace softcd

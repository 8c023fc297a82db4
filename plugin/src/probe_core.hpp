#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "body_questions.hpp"
#include "change_questions.hpp"
#include "hull_questions.hpp"
#include "region_report.hpp"
#include "scene_core.hpp"
#include "softcd/probe.hpp"

namespace softcd::detail {

/// The implementation of a Probe, which owns it.
class ProbeCore final : public SceneUser {
 public:
  ProbeCore(std::shared_ptr<SceneCore> scene, const ProbeOptions& options);
  ~ProbeCore();

  Span<const RayHit> first_hits(Span<const Ray> rays);
  AnswerLists<RayHit> all_hits(Span<const Ray> rays);
  Span<const ClosestPoint> closest_points(Span<const ProbePoint> points);
  /// Finds the overlaps of spheres, capsules or boxes.
  template <class Shape>
  AnswerLists<TriangleOverlap> overlaps(Span<const Shape> shapes) {
    return answers(shapes.size(), {}, [&](SpatialQueries& queries) { return queries.overlaps(shapes); });
  }
  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeHull> hulls);
  Span<const BodyDistance> distances(Span<const ProbeBodies> pairs);
  AnswerLists<TriangleIntersection> intersections(Span<const ProbeBodies> pairs);
  bool has_intersections(const ProbeBodies& pair);
  IntersectionRegions intersection_regions(const ProbeBodies& pair);
  AnswerLists<ChangeIntersection> intersections_after(Span<const ProbeChange> changes);

  void set_options(const ProbeOptions& options);
  const ProbeOptions& options() const { return options_; }
  void set_body_filter(BodyFilter filter) { filter_ = std::move(filter); }

  NeededPositions needed_positions() const override;
  QueryMemories& free_memories() override { return memories_; }
  void drop_memories() noexcept override {
    memories_ = {};
    regions_ = {};
  }

 private:
  /// Returns the results of ask(queries) for `questions` questions; nothing if there are none.
  template <class Ask>
  auto answers(std::size_t questions, ProbeNeeds needs, const Ask& ask) {
    return answers(questions, needs, filter_, ask);
  }
  template <class Ask>
  auto answers(std::size_t questions, ProbeNeeds needs, const BodyFilter& filter, const Ask& ask) {
    require_answerable(questions);
    decltype(ask(std::declval<SpatialQueries&>())) answers{};
    if (questions == 0) return answers;
    const ProbeRequest request = {*this, options_.step_end == StepEnd::t0, needs, filter, bodies_};
    scene_->answer(request, [&](SpatialQueries& queries) { answers = ask(queries); });
    return answers;
  }
  /// Returns the results of ask(queries, questions, number of items) for these pairs.
  template <class Ask>
  auto answers_about(Span<const ProbeBodies> pairs, ProbeNeeds needs, const Ask& ask);
  /// Gives the vertices of regions between different bodies their nearest points of the other body.
  void lead_out(const ProbeBodies& pair);
  /// Returns the question about the bodies of the last answer.
  RegionQuestion region_question(const ProbeBodies& pair) const;
  /// Throws Error when the scene is gone.
  void require_scene() const;
  /// Also throws InvalidInput for too many questions.
  void require_answerable(std::size_t questions) const;

  std::shared_ptr<SceneCore> scene_;
  ProbeOptions options_;
  BodyFilter filter_;
  QueryMemories memories_;
  std::vector<ProbedBody> bodies_;  ///< bodies of the scene, for the last questions
  BodyQuestions body_questions_;
  ChangesInQuestion changes_;
  HullsInQuestion hulls_;
  RegionReport regions_;
};

}  // namespace softcd::detail

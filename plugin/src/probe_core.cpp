#include "probe_core.hpp"

#include <fmt/format.h>

#include <functional>
#include <utility>

#include "validation.hpp"

namespace softcd::detail {

ProbeCore::ProbeCore(std::shared_ptr<SceneCore> scene, const ProbeOptions& options)
    : scene_(std::move(scene)), options_(options) {
  validate_options(options);
  scene_->enter(*this);
}

ProbeCore::~ProbeCore() {
  scene_->leave(*this);
}

void ProbeCore::require_scene() const {
  if (scene_->is_closed()) throw Error("the Scene of this Probe is gone; make a Probe of a Scene that lives as long.");
}

void ProbeCore::require_answerable(std::size_t questions) const {
  require_scene();
  if (questions < kMostElements) return;
  throw InvalidInput(fmt::format("{} questions in one batch are more than 2^31; ask in several calls.", questions));
}

Span<const RayHit> ProbeCore::first_hits(Span<const Ray> rays) {
  return answers(rays.size(), {}, [&](SpatialQueries& queries) { return queries.first_hits(rays); });
}

AnswerLists<RayHit> ProbeCore::all_hits(Span<const Ray> rays) {
  return answers(rays.size(), {}, [&](SpatialQueries& queries) { return queries.all_hits(rays); });
}

Span<const ClosestPoint> ProbeCore::closest_points(Span<const ProbePoint> points) {
  return answers(points.size(), {.sides = true},
                 [&](SpatialQueries& queries) { return queries.closest_points(points); });
}

AnswerLists<TriangleOverlap> ProbeCore::overlaps(Span<const ProbeHull> hulls) {
  return answers(hulls.size(), {}, [&](SpatialQueries& queries) {
    hulls_.prepare(hulls);
    return queries.overlaps(hulls_.questions());
  });
}

template <class Ask>
auto ProbeCore::answers_about(Span<const ProbeBodies> pairs, ProbeNeeds needs, const Ask& ask) {
  for (std::size_t i = 0; i < pairs.size() && !scene_->is_closed(); ++i) {
    for (const BodyId id : {pairs[i].a, pairs[i].b}) {
      if (id == BodyId() || scene_->has_body(id)) continue;
      throw InvalidInput(
          fmt::format("pair {}: body {} is not in the scene; it was removed, or never added. BodyId() "
                      "stands for all.",
                      i, id.value));
    }
  }
  return answers(pairs.size(), needs, [&](SpatialQueries& queries) {
    body_questions_.prepare(pairs, bodies_);
    return ask(queries, body_questions_.questions(), body_questions_.item_count());
  });
}

Span<const BodyDistance> ProbeCore::distances(Span<const ProbeBodies> pairs) {
  return answers_about(pairs, {},
                       [](SpatialQueries& queries, const auto&... of_pairs) { return queries.distances(of_pairs...); });
}

AnswerLists<TriangleIntersection> ProbeCore::intersections(Span<const ProbeBodies> pairs) {
  return answers_about(pairs, {.given_positions = true}, [](SpatialQueries& queries, const auto&... of_pairs) {
    return queries.intersections(of_pairs...);
  });
}

bool ProbeCore::has_intersections(const ProbeBodies& pair) {
  return answers_about({&pair, 1}, {.given_positions = true}, [](SpatialQueries& queries, const auto&... of_pairs) {
    return queries.has_intersections(of_pairs...);
  });
}

IntersectionRegions ProbeCore::intersection_regions(const ProbeBodies& pair) {
  const auto list = [](SpatialQueries& queries, const auto&... of_pairs) { return queries.intersections(of_pairs...); };
  regions_.clear();
  const Span<const TriangleIntersection> pairs =
      answers_about({&pair, 1}, {.sides = true, .given_positions = true}, list).all();
  const RegionQuestion question = region_question(pair);
  if (pairs.empty() && !question.may_be_inside()) return regions_.view();
  const auto find = [&](const SceneStore& scene) { regions_.find(scene, question, pairs); };
  scene_->answer_on_host(std::cref(find));  // A copy would allocate memory.
  lead_out(pair);
  return regions_.view();
}

RegionQuestion ProbeCore::region_question(const ProbeBodies& pair) const {
  return {bodies_, pair, options_.step_end == StepEnd::t0};
}

void ProbeCore::lead_out(const ProbeBodies& pair) {
  for (const RegionReport::Search& search : regions_.searches()) {
    const BodyFilter filter = [&](BodyId body) { return body == search.other; };
    const auto find = [&](SpatialQueries& queries) { return queries.closest_points(search.points); };
    const Span<const ClosestPoint> closest = answers(search.points.size(), {}, filter, find);
    const auto lead_to = [&](const SceneStore& scene) {
      regions_.lead_to(scene, region_question(pair), search, closest);
    };
    scene_->answer_on_host(std::cref(lead_to));
  }
}

AnswerLists<ChangeIntersection> ProbeCore::intersections_after(Span<const ProbeChange> changes) {
  for (std::size_t i = 0; i < changes.size() && !scene_->is_closed(); ++i) {
    if (scene_->has_body(changes[i].body)) continue;
    throw InvalidInput(fmt::format("change {}: body {} is not in the scene; it was removed, or never added.", i,
                                   changes[i].body.value));
  }
  return answers(changes.size(), {}, [&](SpatialQueries& queries) {
    changes_.prepare(changes, bodies_);
    return queries.intersections_after(changes_.questions());
  });
}

void ProbeCore::set_options(const ProbeOptions& options) {
  require_scene();
  validate_options(options);
  options_ = options;
}

NeededPositions ProbeCore::needed_positions() const {
  return {options_.step_end == StepEnd::t0, options_.step_end == StepEnd::t1, false};
}

}  // namespace softcd::detail

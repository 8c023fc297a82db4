#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "softcd/pipeline/bvh.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/memory_account.hpp"
#include "softcd/pipeline/spatial_queries.hpp"
#include "softcd/stages/answer_lists.hpp"
#include "softcd/stages/body_distances.hpp"
#include "softcd/stages/body_pairs.hpp"
#include "softcd/stages/closest_points.hpp"
#include "softcd/stages/hull_questions.hpp"
#include "softcd/stages/mesh_changes.hpp"
#include "softcd/stages/overlaps.hpp"
#include "softcd/stages/ray_casting.hpp"

namespace softcd {

/// The memory of one probe on a backend: questions where the backend reads them, and the last answers.
template <class Backend>
struct ProbeOn final : QueryMemory {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  template <class T>
  using Mirror = typename Backend::template Mirror<T>;
  template <class T>
  using Readback = typename Backend::template Readback<T>;

  /// Memory for answers, of which a question may have several.
  template <class T>
  struct AnswerBuffers {
    Buffer<T> all;
    Buffer<T> noted;  ///< see CountAnswers
    Readback<T> read;
  };

  explicit ProbeOn(std::shared_ptr<MemoryAccount> its_account) : account(std::move(its_account)) {}

  void release() override {
    bodies = {};
    question_count = {};
    rays = {};
    points = {};
    spheres = {};
    capsules = {};
    boxes = {};
    oriented_boxes = {};
    hulls = {};
    hull_points = {};
    bodies_questions = {};
    changes = {};
    removed_triangles = {};
    added_triangles = {};
    new_vertices = {};
    item_count = {};
    counts = {};
    begins = {};
    item_begins = {};
    hits = {};
    closest = {};
    overlaps = {};
    intersections = {};
    change_intersections = {};
    nearest = {};
    least = {};
    distances = {};
  }

  std::shared_ptr<MemoryAccount> account;  ///< of the buffers
  Buffer<ProbedBody> bodies;
  Buffer<std::uint64_t> question_count;
  Mirror<Ray> rays;
  Mirror<ProbePoint> points;
  Mirror<ProbeSphere> spheres;
  Mirror<ProbeCapsule> capsules;
  Mirror<ProbeBox> boxes;
  Mirror<ProbeOrientedBox> oriented_boxes;
  Mirror<HullQuestion> hulls;
  Mirror<Vec3d> hull_points;
  Mirror<BodiesQuestion> bodies_questions;
  Mirror<ChangeQuestion> changes;
  Mirror<std::uint32_t> removed_triangles;
  Mirror<Triangle> added_triangles;
  Mirror<Vec3d> new_vertices;
  Buffer<std::uint64_t> item_count;
  Buffer<std::uint32_t> counts;       ///< of answers, per question
  Buffer<std::uint64_t> begins;       ///< of answers, per question; then the number of answers
  Buffer<std::uint64_t> item_begins;  ///< the same per item
  AnswerBuffers<RayHit> hits;
  Buffer<ClosestPoint> closest;
  AnswerBuffers<TriangleOverlap> overlaps;
  AnswerBuffers<TriangleIntersection> intersections;
  AnswerBuffers<ChangeIntersection> change_intersections;
  Buffer<NearestTriangle> nearest;
  Buffer<LeastDistance> least;
  Buffer<BodyDistance> distances;
  Readback<std::uint64_t> read_begins;
  Readback<ClosestPoint> read_closest;
  Readback<BodyDistance> read_distances;
  Readback<LeastDistance> read_least;
};

/// The hierarchies of both ends of the step, each as of the last question about that end.
template <class Backend>
using Bvhs = std::array<Bvh<Backend>, 2>;

/// Answers one probe's questions.
template <class Backend>
class SpatialQueriesOn final : public SpatialQueries {
 public:
  SpatialQueriesOn(Backend& backend, ProbeOn<Backend>& probe, const ProbedSceneView& scene)
      : backend_(backend), probe_(probe), scene_(scene) {}

  Span<const RayHit> first_hits(Span<const Ray> rays) override {
    const Count count = send(probe_.rays, rays);
    probe_.hits.all.reserve(backend_, rays.size(), 0);
    backend_.for_each("first_hits", count, FindFirstHit{scene_, probe_.rays.data(), probe_.hits.all.data()});
    return probe_.hits.read.read(backend_, probe_.hits.all, rays.size());
  }

  AnswerLists<RayHit> all_hits(Span<const Ray> rays) override {
    const Count count = send(probe_.rays, rays);
    return list(count, ListHits{scene_, probe_.rays.data()}, probe_.hits);
  }

  Span<const ClosestPoint> closest_points(Span<const ProbePoint> points) override {
    const Count count = send(probe_.points, points);
    probe_.closest.reserve(backend_, points.size(), 0);
    backend_.for_each("closest_points", count, FindClosestPoint{scene_, probe_.points.data(), probe_.closest.data()});
    return probe_.read_closest.read(backend_, probe_.closest, points.size());
  }

  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeSphere> spheres) override {
    const Count count = send(probe_.spheres, spheres);
    return list(count, ListOverlaps<const ProbeSphere*, SphereShape>{scene_, probe_.spheres.data()}, probe_.overlaps);
  }

  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeCapsule> capsules) override {
    const Count count = send(probe_.capsules, capsules);
    return list(count, ListOverlaps<const ProbeCapsule*, CapsuleShape>{scene_, probe_.capsules.data()},
                probe_.overlaps);
  }

  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeBox> boxes) override {
    const Count count = send(probe_.boxes, boxes);
    return list(count, ListOverlaps<const ProbeBox*, BoxShape>{scene_, probe_.boxes.data()}, probe_.overlaps);
  }

  AnswerLists<TriangleOverlap> overlaps(Span<const ProbeOrientedBox> boxes) override {
    const Count count = send(probe_.oriented_boxes, boxes);
    return list(count, ListOverlaps<const ProbeOrientedBox*, OrientedBoxShape>{scene_, probe_.oriented_boxes.data()},
                probe_.overlaps);
  }

  AnswerLists<TriangleOverlap> overlaps(const HullQuestions& questions) override {
    const Count count = send(probe_.hulls, questions.hulls);
    const HullQuestions asked = {{probe_.hulls.data(), questions.hulls.size()},
                                 there(probe_.hull_points, questions.points)};
    return list(count, ListOverlaps<HullQuestions, HullShape>{scene_, asked}, probe_.overlaps);
  }

  Span<const BodyDistance> distances(Span<const BodiesQuestion> questions, std::uint64_t item_count) override {
    const BodiesQuestions asked = send_bodies(questions);
    const Count count = asked_count(questions.size());
    const Count items = count_items(item_count);
    clear_least(count);
    probe_.nearest.reserve(backend_, item_count, 0);
    probe_.distances.reserve(backend_, questions.size(), 0);
    LeastDistance* const least = probe_.least.data();
    NearestTriangle* const nearest = probe_.nearest.data();
    backend_.for_each("nearest_triangles", items, FindNearestTriangle{asked, least, nearest});
    backend_.for_each("nearest_items", items, ChooseNearestItem{asked, least, nearest});
    backend_.for_each("distances", count, DescribeDistance{asked, least, nearest, probe_.distances.data()});
    return probe_.read_distances.read(backend_, probe_.distances, questions.size());
  }

  AnswerLists<TriangleIntersection> intersections(Span<const BodiesQuestion> questions,
                                                  std::uint64_t item_count) override {
    const BodiesQuestions asked = send_bodies(questions);
    return list_by_items(asked_count(questions.size()), asked.questions, count_items(item_count),
                         ListIntersections{asked}, probe_.intersections);
  }

  bool has_intersections(Span<const BodiesQuestion> questions, std::uint64_t item_count) override {
    const BodiesQuestions asked = send_bodies(questions);
    clear_least(asked_count(1));
    LeastDistance* const least = probe_.least.data();
    backend_.for_each("find_intersection", count_items(item_count), FindIntersection{asked, &least->bits});
    return probe_.read_least.read(backend_, probe_.least, 1)[0].bits == 0;
  }

  AnswerLists<ChangeIntersection> intersections_after(const ChangeQuestions& questions) override {
    const Count changes = send(probe_.changes, questions.changes);
    const ChangeQuestions asked = {{probe_.changes.data(), questions.changes.size()},
                                   there(probe_.removed_triangles, questions.removed),
                                   there(probe_.added_triangles, questions.added),
                                   there(probe_.new_vertices, questions.new_vertices)};
    return list_by_items(changes, probe_.changes.data(), count_items(questions.added.size()),
                         ListChangeIntersections{{scene_, asked}}, probe_.change_intersections);
  }

 private:
  /// Returns the values where the backend reads them.
  template <class T>
  Span<const T> there(typename Backend::template Mirror<T>& mirror, Span<const T> values) {
    const Range all{0, values.size()};
    mirror.follow(backend_, values, Span<const Range>(&all, 1));
    return {mirror.data(), values.size()};
  }

  template <class Question>
  Count send(typename Backend::template Mirror<Question>& mirror, Span<const Question> questions) {
    const std::uint64_t count = questions.size();
    there(mirror, questions);
    probe_.question_count.reserve(backend_, 1, 0);
    backend_.upload(probe_.question_count, Span<const std::uint64_t>(&count, 1));
    return {probe_.question_count.data(), count};
  }

  BodiesQuestions send_bodies(Span<const BodiesQuestion> questions) {
    send(probe_.bodies_questions, questions);
    return {scene_, probe_.bodies_questions.data(), static_cast<std::uint32_t>(questions.size())};
  }

  Count count_items(std::uint64_t count) {
    probe_.item_count.reserve(backend_, 1, 0);
    backend_.upload(probe_.item_count, Span<const std::uint64_t>(&count, 1));
    return {probe_.item_count.data(), count};
  }

  /// Returns the count of the questions that were sent last; `capacity` is their number, or less.
  Count asked_count(std::uint64_t capacity) const { return {probe_.question_count.data(), capacity}; }

  void clear_least(Count count) {
    probe_.least.reserve(backend_, count.capacity, 0);
    backend_.for_each("clear_least", count, ClearLeastDistance{probe_.least.data()});
  }

  template <class Lister, class Buffers>
  void count_answers(Count items, const Lister& lister, typename Backend::template Buffer<std::uint64_t>& begins,
                     Buffers& buffers) {
    const std::uint64_t count = items.capacity;
    probe_.counts.reserve(backend_, count, 0);
    buffers.noted.reserve(backend_, kNotedAnswers * count, 0);
    begins.reserve(backend_, count + 1, 0);
    backend_.for_each("count_answers", items, CountAnswers<Lister>{lister, probe_.counts.data(), buffers.noted.data()});
    backend_.exclusive_scan("answer_begins", items, probe_.counts.data(), begins.data(), begins.data() + count);
  }

  template <class Lister, class Buffers>
  AnswerLists<typename Lister::Answer> write_answers(Count items, const Lister& lister, const std::uint64_t* begins,
                                                     Span<const std::uint64_t> read_begins, Buffers& buffers) {
    const std::uint64_t total = read_begins[read_begins.size() - 1];
    buffers.all.reserve(backend_, total, 0);
    const WriteAnswers<Lister> write{lister, begins, buffers.noted.data(), buffers.all.data()};
    if (total > 0) backend_.for_each("write_answers", items, write);
    return {read_begins, buffers.read.read(backend_, buffers.all, total)};
  }

  /// Counts answers, and then writes them where the counts say.
  template <class Lister, class Buffers>
  AnswerLists<typename Lister::Answer> list(Count questions, const Lister& lister, Buffers& buffers) {
    count_answers(questions, lister, probe_.begins, buffers);
    const Span<const std::uint64_t> read_begins =
        probe_.read_begins.read(backend_, probe_.begins, questions.capacity + 1);
    return write_answers(questions, lister, probe_.begins.data(), read_begins, buffers);
  }

  /// Does the same if each question, in the backend's memory, has many items.
  template <class Lister, class Question, class Buffers>
  AnswerLists<typename Lister::Answer> list_by_items(Count questions, const Question* asked, Count items,
                                                     const Lister& lister, Buffers& buffers) {
    count_answers(items, lister, probe_.item_begins, buffers);
    const std::uint64_t none = 0;
    if (items.capacity == 0) backend_.upload(probe_.item_begins, Span<const std::uint64_t>(&none, 1));
    const std::uint64_t* const item_begins = probe_.item_begins.data();
    probe_.begins.reserve(backend_, questions.capacity + 1, 0);
    backend_.for_each(
        "question_begins", questions,
        GatherBegins<Question>{asked, item_begins, items.capacity, questions.capacity, probe_.begins.data()});
    const Span<const std::uint64_t> read_begins =
        probe_.read_begins.read(backend_, probe_.begins, questions.capacity + 1);
    return write_answers(items, lister, item_begins, read_begins, buffers);
  }

  Backend& backend_;
  ProbeOn<Backend>& probe_;
  ProbedSceneView scene_;
};

}  // namespace softcd

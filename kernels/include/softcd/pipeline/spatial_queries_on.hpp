#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "softcd/pipeline/bvh.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/memory_account.hpp"
#include "softcd/pipeline/spatial_queries.hpp"
#include "softcd/stages/answer_lists.hpp"
#include "softcd/stages/closest_points.hpp"
#include "softcd/stages/overlaps.hpp"
#include "softcd/stages/ray_casting.hpp"

namespace softcd {

/// What one probe keeps on a backend: questions where the backend reads them, and its last answers.
template <class Backend>
struct ProbeOn final : QueryMemory {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  template <class T>
  using Mirror = typename Backend::template Mirror<T>;
  template <class T>
  using Readback = typename Backend::template Readback<T>;

  explicit ProbeOn(std::shared_ptr<MemoryAccount> its_account) : account(std::move(its_account)) {}

  void release() override {
    bodies = {};
    question_count = {};
    rays = {};
    points = {};
    spheres = {};
    boxes = {};
    oriented_boxes = {};
    counts = {};
    begins = {};
    hits = {};
    closest = {};
    overlaps = {};
  }

  std::shared_ptr<MemoryAccount> account;  ///< of the buffers
  Buffer<ProbedBody> bodies;
  Buffer<std::uint64_t> question_count;
  Mirror<Ray> rays;
  Mirror<QueryPoint> points;
  Mirror<QuerySphere> spheres;
  Mirror<QueryBox> boxes;
  Mirror<QueryOrientedBox> oriented_boxes;
  Buffer<std::uint32_t> counts;  ///< of answers, per question
  Buffer<std::uint64_t> begins;  ///< and where they begin; then how many there are
  Buffer<RayHit> hits;
  Buffer<ClosestPoint> closest;
  Buffer<TriangleOverlap> overlaps;
  Readback<std::uint64_t> read_begins;
  Readback<RayHit> read_hits;
  Readback<ClosestPoint> read_closest;
  Readback<TriangleOverlap> read_overlaps;
};

/// Hierarchies of both ends of the step, each of what was there when somebody last asked.
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
    probe_.hits.reserve(backend_, rays.size(), 0);
    backend_.for_each("first_hits", count, FindFirstHit{scene_, probe_.rays.data(), probe_.hits.data()});
    return probe_.read_hits.read(backend_, probe_.hits, rays.size());
  }

  AnswerLists<RayHit> all_hits(Span<const Ray> rays) override {
    const Count count = send(probe_.rays, rays);
    return list(count, ListHits{scene_, probe_.rays.data()}, probe_.hits, probe_.read_hits);
  }

  Span<const ClosestPoint> closest_points(Span<const QueryPoint> points) override {
    const Count count = send(probe_.points, points);
    probe_.closest.reserve(backend_, points.size(), 0);
    backend_.for_each("closest_points", count, FindClosestPoint{scene_, probe_.points.data(), probe_.closest.data()});
    return probe_.read_closest.read(backend_, probe_.closest, points.size());
  }

  AnswerLists<TriangleOverlap> overlaps(Span<const QuerySphere> spheres) override {
    const Count count = send(probe_.spheres, spheres);
    return list(count, ListOverlaps<QuerySphere, SphereShape>{scene_, probe_.spheres.data()}, probe_.overlaps,
                probe_.read_overlaps);
  }

  AnswerLists<TriangleOverlap> overlaps(Span<const QueryBox> boxes) override {
    const Count count = send(probe_.boxes, boxes);
    return list(count, ListOverlaps<QueryBox, BoxShape>{scene_, probe_.boxes.data()}, probe_.overlaps,
                probe_.read_overlaps);
  }

  AnswerLists<TriangleOverlap> overlaps(Span<const QueryOrientedBox> boxes) override {
    const Count count = send(probe_.oriented_boxes, boxes);
    return list(count, ListOverlaps<QueryOrientedBox, OrientedBoxShape>{scene_, probe_.oriented_boxes.data()},
                probe_.overlaps, probe_.read_overlaps);
  }

 private:
  template <class Question>
  Count send(typename Backend::template Mirror<Question>& mirror, Span<const Question> questions) {
    const std::uint64_t count = questions.size();
    const Range all{0, count};
    mirror.follow(backend_, questions, Span<const Range>(&all, 1));
    probe_.question_count.reserve(backend_, 1, 0);
    backend_.upload(probe_.question_count, Span<const std::uint64_t>(&count, 1));
    return {probe_.question_count.data(), count};
  }

  /// Counted, and then written where the counts say.
  template <class Lister, class Answers, class ReadAnswers>
  AnswerLists<typename Lister::Answer> list(Count questions, const Lister& lister, Answers& answers,
                                            ReadAnswers& read_answers) {
    const std::uint64_t count = questions.capacity;
    probe_.counts.reserve(backend_, count, 0);
    probe_.begins.reserve(backend_, count + 1, 0);
    std::uint64_t* const begins = probe_.begins.data();
    backend_.for_each("count_answers", questions, CountAnswers<Lister>{lister, probe_.counts.data()});
    backend_.exclusive_scan("answer_begins", questions, probe_.counts.data(), begins, begins + count);
    const Span<const std::uint64_t> read_begins = probe_.read_begins.read(backend_, probe_.begins, count + 1);
    const std::uint64_t total = read_begins[count];
    answers.reserve(backend_, total, 0);
    backend_.for_each("write_answers", questions, WriteAnswers<Lister>{lister, begins, answers.data()});
    return {read_begins, read_answers.read(backend_, answers, total)};
  }

  Backend& backend_;
  ProbeOn<Backend>& probe_;
  ProbedSceneView scene_;
};

}  // namespace softcd

#include "body_questions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "command_line/choices.hpp"
#include "mesh_generators.hpp"
#include "timing.hpp"
#ifdef SOFTCD_BENCH_HAS_BULLET
#include "bullet_overlaps.hpp"
#endif

namespace softcd::benchmarks {
namespace {

// In units of the mesh's extent.
constexpr double kShapeRadius = 0.01;
constexpr double kBallRadius = 0.05;
constexpr int kBallLevel = 1;  ///< 80 triangles
// The number of questions that are answered by comparing every pair of triangles.
constexpr std::size_t kTriedBalls = 2;
constexpr std::size_t kTriedChanges = 10;

Vec3d at(const std::vector<Vec3f>& x, std::uint32_t vertex) {
  return vec3_cast<double>(x[vertex]);
}

/// Measures the time of `ask`, which returns the number of results.
template <class Ask>
BodyQuestionTime timed(BodyQuestion question, std::string name, std::size_t questions, int repetitions,
                       const Ask& ask) {
  BodyQuestionTime time{question, std::move(name), questions, 0};
  std::vector<double> milliseconds;
  for (int i = 0; i <= repetitions; ++i) milliseconds.push_back(milliseconds_of([&] { time.answers = ask(); }));
  time.microseconds_each = 1e3 * median_without_first(std::move(milliseconds)) / static_cast<double>(questions);
  return time;
}

/// Throws unless two results agree. Positions that are rounded to float differently may change a few results.
void expect_near(const char* what, double theirs, double ours) {
  if (std::abs(theirs - ours) <= 1e-3 * ours + 1e-6) return;
  throw std::runtime_error(
      fmt::format("the test of every pair of triangles has other results: {} {} instead of {}", what, theirs, ours));
}

}  // namespace

BodyQuestions::BodyQuestions(const MeshView& mesh, double extent, std::size_t questions)
    : mesh_(mesh), extent_(extent) {
  make_shapes(std::max<std::size_t>(10, questions / 100));
  make_changes(std::max<std::size_t>(10, questions / 100));
  make_balls(std::max<std::size_t>(kTriedBalls, questions / 10000));
}

Vec3d BodyQuestions::near_surface(double distance) {
  const Triangle& t = mesh_.triangles[random_.below(static_cast<std::uint32_t>(mesh_.triangles.size()))];
  return at(mesh_.x, t.v[0]) + random_.uniform(0, distance) * random_.direction();
}

void BodyQuestions::make_shapes(std::size_t count) {
  const double radius = kShapeRadius * extent_;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d from = near_surface(2 * radius);
    capsules_.push_back({from, from + 4 * radius * random_.direction(), radius});
    const Vec3d centre = near_surface(2 * radius);
    std::vector<Vec3d>& points = hull_points_.emplace_back();
    for (int corner = 0; corner < 8; ++corner) points.push_back(centre + 2 * radius * random_.direction());
  }
  for (const std::vector<Vec3d>& points : hull_points_) hulls_.push_back({points, 0.25 * radius});
}

/// Makes changes that replace a triangle by three around a new vertex, up to an edge's length away from the triangle's
/// middle.
void BodyQuestions::make_changes(std::size_t count) {
  const auto new_vertex = static_cast<std::uint32_t>(mesh_.x.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t removed = random_.below(static_cast<std::uint32_t>(mesh_.triangles.size()));
    const Triangle& t = mesh_.triangles[removed];
    const Vec3d a = at(mesh_.x, t.v[0]);
    const Vec3d b = at(mesh_.x, t.v[1]);
    const double edge = std::sqrt(squared_norm(b - a));
    const Vec3d vertex = (1.0 / 3) * (a + b + at(mesh_.x, t.v[2])) + random_.uniform(0, edge) * random_.direction();
    changes_.push_back(
        {{removed},
         {{{t.v[0], t.v[1], new_vertex}}, {{t.v[1], t.v[2], new_vertex}}, {{t.v[2], t.v[0], new_vertex}}},
         {vertex}});
  }
}

/// Makes balls, every other one around a point of the mesh.
void BodyQuestions::make_balls(std::size_t count) {
  const double radius = kBallRadius * extent_;
  const test::Mesh ball = test::icosphere(kBallLevel, radius);
  for (std::size_t i = 0; i < count; ++i) {
    Vec3d centre = near_surface(0.5 * radius);
    if (i % 2 != 0) centre = centre + 4 * radius * random_.direction();
    Ball& placed = balls_.emplace_back();
    placed.triangles = ball.triangles;
    for (const Vec3d& x : ball.positions) placed.x.push_back(vec3_cast<float>(centre + x));
  }
}

std::string BodyQuestions::description() const {
  return fmt::format("{} balls of {} triangles, {} capsules, {} hulls of 8 points, {} changes that add 3 triangles",
                     balls_.size(), balls_[0].triangles.size(), capsules_.size(), hulls_.size(), changes_.size());
}

std::vector<BodyQuestionTime> BodyQuestions::measure(Backend backend, int repetitions) {
  SceneOptions options;
  options.backend = backend;
  Scene scene(options);
  const BodyId body = scene.add_body({mesh_.triangles, static_cast<std::uint32_t>(mesh_.x.size()), {}});
  scene.set_positions(body, mesh_.x);
  std::vector<BodyQuestionTime> times = measure_mesh(scene, body, repetitions);
  const std::vector<BodyQuestionTime> of_pairs = measure_pairs(scene, body, repetitions);
  times.insert(times.end(), of_pairs.begin(), of_pairs.end());
  return times;
}

std::vector<BodyQuestionTime> BodyQuestions::measure_mesh(Scene& scene, BodyId body, int repetitions) {
  Probe probe(scene);
  const std::string name = fmt::format("softcd, {}", demo::name_of(scene.backend()));
  std::vector<ProbeChange> changes;
  for (const Change& change : changes_) changes.push_back({body, change.removed, change.added, change.new_vertices});
  std::vector<BodyQuestionTime> times = {
      timed(BodyQuestion::within, name, 1, repetitions,
            [&] {
              return probe.intersections({body, body}).size();
            }),
      timed(BodyQuestion::capsules, name, capsules_.size(), repetitions,
            [&] { return probe.overlaps(capsules_).all().size(); }),
      timed(BodyQuestion::hulls, name, hulls_.size(), repetitions, [&] { return probe.overlaps(hulls_).all().size(); }),
      timed(BodyQuestion::changes, name, changes.size(), repetitions,
            [&] { return probe.intersections_after(changes).all().size(); })};
  const AnswerLists<ChangeIntersection> found = probe.intersections_after(changes);
  answers_.changes.clear();
  for (std::size_t i = 0; i < kTriedChanges; ++i) answers_.changes.push_back(found[i].size());
  return times;
}

std::vector<BodyQuestionTime> BodyQuestions::measure_pairs(Scene& scene, BodyId body, int repetitions) {
  std::vector<ProbeBodies> pairs;
  for (const Ball& ball : balls_) {
    pairs.push_back({scene.add_body({ball.triangles, static_cast<std::uint32_t>(ball.x.size()), {}}), body});
    scene.set_positions(pairs.back().a, ball.x);
  }
  Probe probe(scene);
  const std::string name = fmt::format("softcd, {}", demo::name_of(scene.backend()));
  std::vector<BodyQuestionTime> times = {
      timed(BodyQuestion::distance, name, pairs.size(), repetitions, [&] { return probe.distances(pairs).size(); }),
      timed(BodyQuestion::intersections, name, pairs.size(), repetitions,
            [&] { return probe.intersections(pairs).all().size(); }),
      timed(BodyQuestion::has_intersections, name, pairs.size(), repetitions, [&] {
        return static_cast<std::size_t>(std::count_if(
            pairs.begin(), pairs.end(), [&](const ProbeBodies& pair) { return probe.has_intersections(pair); }));
      })};
  answers_.distances.clear();
  answers_.intersections.clear();
  const Span<const BodyDistance> distances = probe.distances(pairs);
  for (std::size_t i = 0; i < kTriedBalls; ++i) answers_.distances.push_back(distances[i].distance);
  const AnswerLists<TriangleIntersection> found = probe.intersections(pairs);
  for (std::size_t i = 0; i < kTriedBalls; ++i) answers_.intersections.push_back(found[i].size());
  return times;
}

std::vector<BodyQuestionTime> BodyQuestions::measure_rivals([[maybe_unused]] int repetitions) const {
  std::vector<BodyQuestionTime> times;
  add_every_pair(times);
#ifdef SOFTCD_BENCH_HAS_BULLET
  add_bullet(times, repetitions);
#endif
  return times;
}

/// Measures the comparison of every pair, once, because it takes long.
void BodyQuestions::add_every_pair(std::vector<BodyQuestionTime>& times) const {
  const auto add = [&](BodyQuestion question, std::size_t questions, const auto& answers_of) {
    BodyQuestionTime time{question, "every two triangles", questions, 0};
    const double ms = milliseconds_of([&] {
      for (std::size_t i = 0; i < questions; ++i) time.answers += answers_of(i);
    });
    time.microseconds_each = 1e3 * ms / static_cast<double>(questions);
    times.push_back(time);
  };
  const auto ball = [&](std::size_t i) { return MeshView{balls_[i].triangles, balls_[i].x}; };
  add(BodyQuestion::distance, kTriedBalls, [&](std::size_t i) {
    expect_near("distance", distance_by_every_pair(ball(i), mesh_), answers_.distances[i]);
    return std::size_t{1};
  });
  add(BodyQuestion::intersections, kTriedBalls, [&](std::size_t i) {
    const std::size_t found = intersections_by_every_pair(ball(i), mesh_);
    expect_near("intersections", double(found), double(answers_.intersections[i]));
    return found;
  });
  add(BodyQuestion::changes, kTriedChanges, [&](std::size_t i) {
    const Change& change = changes_[i];
    const std::size_t found =
        intersections_after_by_every_pair(mesh_, {BodyId(), change.removed, change.added, change.new_vertices});
    expect_near("intersections of a change", double(found), double(answers_.changes[i]));
    return found;
  });
}

#ifdef SOFTCD_BENCH_HAS_BULLET
void BodyQuestions::add_bullet(std::vector<BodyQuestionTime>& times, int repetitions) const {
  const BulletOverlaps bullet(mesh_.triangles, mesh_.x, kShapeRadius * extent_);
  times.push_back(
      timed(BodyQuestion::capsules, "Bullet", capsules_.size(), repetitions, [&] { return bullet.count(capsules_); }));
  times.push_back(
      timed(BodyQuestion::hulls, "Bullet", hulls_.size(), repetitions, [&] { return bullet.count(hulls_); }));
}
#endif

}  // namespace softcd::benchmarks

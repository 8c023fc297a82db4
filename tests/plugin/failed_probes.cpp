#include <gtest/gtest.h>

#include <vector>

#include "failing_allocations.hpp"
#include "probing.hpp"

// Whichever allocation of a probe's call fails, the next call succeeds.
namespace softcd::test {
namespace {

struct Answers {
  std::vector<std::uint32_t> hits, all, closest, nearest, intersecting;

  friend bool operator==(const Answers&, const Answers&) = default;
};

/// Questions for a probe, and memory for its results.
class Interview {
 public:
  Interview() {
    Random random(4);
    for (int i = 0; i < 40; ++i) {
      rays_.push_back({random.in_box(2), random.direction()});
      points_.push_back({random.in_box(2)});
    }
  }

  /// Makes one call of each kind, without allocations of the test's own. Returns the number of results.
  std::size_t count(Probe& probe) const {
    const std::size_t hits = probe.first_hits(rays_).size();
    const std::size_t all = probe.all_hits(rays_).all().size();
    const std::size_t distances = probe.distances(pairs_).size();
    const std::size_t intersections = probe.intersections(pairs_).all().size();
    const std::size_t changes = probe.intersections_after(change()).size();
    const ProbeHull hull = {corners_, 0.1};
    const std::size_t overlaps = probe.overlaps({&hull, 1}).all().size();
    return hits + all + distances + intersections + changes + overlaps + probe.closest_points(points_).size();
  }

  Answers ask(Probe& probe) const {
    Answers answers;
    for (const RayHit& hit : probe.first_hits(rays_)) answers.hits.push_back(hit.triangle);
    for (const RayHit& hit : probe.all_hits(rays_).all()) answers.all.push_back(hit.triangle);
    for (const ClosestPoint& point : probe.closest_points(points_)) answers.closest.push_back(point.triangle);
    for (const BodyDistance& distance : probe.distances(pairs_)) answers.nearest.push_back(distance.triangle_a);
    for (const TriangleIntersection& pair : probe.intersections(pairs_).all()) {
      answers.intersecting.push_back(pair.triangle_a);
    }
    return answers;
  }

 private:
  ProbeChange change() const { return {BodyId{0}, {}, added_, {}}; }

  std::vector<Ray> rays_;
  std::vector<ProbePoint> points_;
  std::vector<Vec3d> corners_{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.25, 1}};
  std::vector<Triangle> added_{{{0, 1, 2}}, {{3, 4, 5}}};
  std::vector<ProbeBodies> pairs_{{}, {BodyId{0}, BodyId{1}}};
};

Scene small_scene() {
  return {still(outward_ball(1, 1.0), {}), still(soup_with_everything(3), {})};
}

TEST(FailedProbes, answer_the_next_time) {
  const Interview interview;
  ProbedBodies sound(small_scene());
  const Answers expected = interview.ask(sound.probe);
  const std::size_t count = interview.count(sound.probe);
  for (const bool is_first : {true, false}) {
    const std::uint64_t failures = for_every_allocation([&](std::uint64_t n) {
      SCOPED_TRACE(testing::Message() << "allocation " << n);
      ProbedBodies probed(small_scene());
      if (!is_first) {
        interview.ask(probed.probe);
        probed.scene.set_positions(probed.ids[0], probed.bodies[0].x_t1);
      }
      std::size_t found = 0;
      bool has_failed = false;
      {
        const FailingAllocation failing(n);
        try {
          found = interview.count(probed.probe);
        } catch (const OutOfMemory&) {
          found = count;
        }
        has_failed = failing.has_failed();
      }
      EXPECT_EQ(found, count);
      EXPECT_EQ(interview.ask(probed.probe), expected);
      return has_failed && !HasFailure();
    });
    EXPECT_GT(failures, is_first ? 20U : 0U);
  }
}

/// Curves and regions take many allocations, so the scene is small.
TEST(FailedProbes, find_regions_the_next_time) {
  const Mesh ball = outward_ball(0, 1.0);
  const Scene bodies = {still(ball, {}), still(moved(ball, {1.25, 0.125, 0.0625}), {}),
                        still(moved(ball, {9, 0, 0}), {})};
  const auto count = [](Probe& probe) {
    const IntersectionRegions found = probe.intersection_regions();
    return found.regions.size() + found.vertices.size() + found.points.size();
  };
  ProbedBodies sound(bodies);
  const std::size_t expected = count(sound.probe);
  EXPECT_GT(expected, 10U);
  const std::uint64_t failures = for_every_allocation([&](std::uint64_t n) {
    SCOPED_TRACE(testing::Message() << "allocation " << n);
    ProbedBodies probed(bodies);
    bool has_failed = false;
    {
      const FailingAllocation failing(n);
      try {
        EXPECT_EQ(count(probed.probe), expected);
      } catch (const OutOfMemory&) {
      }
      has_failed = failing.has_failed();
    }
    EXPECT_EQ(count(probed.probe), expected);
    return has_failed && !HasFailure();
  });
  EXPECT_GT(failures, 20U);
}

TEST(FailedProbes, leave_the_scene_as_it_was_where_none_can_be_made) {
  const Interview interview;
  ProbedBodies probed(small_scene());
  const Answers expected = interview.ask(probed.probe);
  const std::uint64_t failures = for_every_allocation([&](std::uint64_t n) {
    bool has_thrown = false;
    {
      const FailingAllocation failing(n);
      try {
        const Probe probe(probed.scene);
      } catch (const OutOfMemory&) {
        has_thrown = true;
      }
    }
    EXPECT_EQ(interview.ask(probed.probe), expected);
    return has_thrown && !testing::Test::HasFailure();
  });
  EXPECT_GT(failures, 0U);
}

}  // namespace
}  // namespace softcd::test

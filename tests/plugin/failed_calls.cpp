#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "expectations.hpp"
#include "failing_allocations.hpp"
#include "mesh_generators.hpp"
#include "scene_parts.hpp"

// Whichever allocation of a call fails, the pipeline stays as it was before.
namespace softcd::test {
namespace {

/// Three small bodies that touch each other and themselves.
Scene small_scene(bool has_strays) {
  Scene scene{still(crumpled_cloth(6, 5, 0.25, 0.05, 1), everything(0.04F)),
              moving(moved(grid_cloth(4, 4, 0.25), {0.1, 0.1, 0.06}),
                     translated(grid_cloth(4, 4, 0.25).positions, {0.15, 0.1, 0.02}), everything(0.05F)),
              still(moved(icosphere(0, 0.3), {0.4, 0.4, 0.1}), everything(0.03F))};
  if (has_strays) {
    for (const std::size_t v : {0U, 7U, 13U}) scene[0].x_t1[v].y = std::numeric_limits<double>::quiet_NaN();
    scene[2].x_t1[3].x = std::numeric_limits<double>::infinity();
  }
  return scene;
}

struct Case {
  Detection detection;
  bool has_strays;
};

class FailedCalls : public testing::TestWithParam<Case> {
 protected:
  static Scene scene() { return small_scene(GetParam().has_strays); }
  static LoadedScene fresh() { return load(scene(), test_options(GetParam().detection)); }

  static std::vector<Contact> expected() {
    LoadedScene loaded = fresh();
    return copy_of(loaded.pipeline.detect());
  }

  /// Lets `change` fail at each of its allocations. Nothing may have changed then, and the next attempt must succeed.
  /// `complete` follows a change that has succeeded.
  template <class Change, class Complete>
  static void expect_all_or_nothing(const Change& change, const Complete& complete) {
    const std::vector<Contact> before = expected();
    std::vector<Contact> after;
    for_every_allocation([&](std::uint64_t n) {
      SCOPED_TRACE(testing::Message() << "allocation " << n);
      LoadedScene loaded = fresh();
      loaded.pipeline.detect();
      const bool has_succeeded = succeeds_although(n, [&] { change(loaded); });
      if (!has_succeeded) {
        EXPECT_TRUE(identical(before, loaded.pipeline.detect()));
        change(loaded);
      }
      complete(loaded);
      const std::vector<Contact> found = copy_of(loaded.pipeline.detect());
      EXPECT_FALSE(found.empty());
      EXPECT_TRUE(n == 1 || identical(after, found));
      after = found;
      return !has_succeeded && !HasFailure();
    });
  }

  /// The result of a call in which an allocation was to fail.
  struct Outcome {
    bool threw_out_of_memory = false;
    bool has_failed = false;  ///< the allocation
  };
  /// Runs the call and nothing else: checks allocate, too, and may not be able to fail.
  template <class Call>
  static Outcome with_failing(std::uint64_t n, const Call& call) {
    Outcome outcome;
    const FailingAllocation failing(n);
    try {
      call();
    } catch (const OutOfMemory&) {
      outcome.threw_out_of_memory = true;
    }
    outcome.has_failed = failing.has_failed();
    return outcome;
  }

  /// Returns whether the call has fewer than n allocations. Otherwise it must throw OutOfMemory.
  template <class Call>
  static bool succeeds_although(std::uint64_t n, const Call& call) {
    const Outcome outcome = with_failing(n, call);
    EXPECT_TRUE(outcome.threw_out_of_memory || !outcome.has_failed) << "survived without a word";
    return !outcome.threw_out_of_memory;
  }

  /// Returns whether a detection has fewer than n allocations. Otherwise it must throw OutOfMemory or manage without.
  static bool detects_although(std::uint64_t n, CollisionPipeline& pipeline, const std::vector<Contact>& wanted) {
    Span<const Contact> found;
    const Outcome outcome = with_failing(n, [&] { found = pipeline.detect(); });
    if (outcome.threw_out_of_memory) return false;
    EXPECT_TRUE(identical(wanted, found));
    return !outcome.has_failed;
  }
};

constexpr auto kNothing = [](LoadedScene& /*loaded*/) {};

TEST_P(FailedCalls, add_body) {
  const SceneBody more = still(moved(icosphere(0, 0.4), {0.7, 0.4, 0.1}), everything(0.03F));
  BodyId id;
  expect_all_or_nothing([&](LoadedScene& loaded) { id = loaded.pipeline.scene.add_body(desc_of(more)); },
                        [&](LoadedScene& loaded) { loaded.pipeline.scene.set_positions(id, more.x_t1); });
}

TEST_P(FailedCalls, update_body) {
  const SceneBody other = still(moved(icosphere(0, 0.4), {0.7, 0.4, 0.1}), everything(0.03F));
  expect_all_or_nothing([&](LoadedScene& loaded) { loaded.pipeline.scene.update_body(loaded.ids[0], desc_of(other)); },
                        [&](LoadedScene& loaded) { loaded.pipeline.scene.set_positions(loaded.ids[0], other.x_t1); });
}

TEST_P(FailedCalls, update_body_where_some_triangles_change) {
  // Within the body's place, and beyond it.
  for (const std::size_t added : {0U, 40U}) {
    SceneBody other = scene()[0];
    std::swap(other.triangles[3], other.triangles[20]);
    other.triangles.insert(other.triangles.end(), added, other.triangles[5]);
    const std::vector<std::uint32_t> changed{3, 20};
    expect_all_or_nothing(
        [&](LoadedScene& loaded) { loaded.pipeline.scene.update_body(loaded.ids[0], desc_of(other), changed); },
        [&](LoadedScene& loaded) { loaded.pipeline.scene.set_positions(loaded.ids[0], other.x_t1); });
  }
}

/// No memory is left for the error's text either.
TEST_P(FailedCalls, throw_nothing_but_out_of_memory_where_none_is_left) {
  const SceneBody more = still(moved(icosphere(0, 0.4), {0.7, 0.4, 0.1}), everything(0.03F));
  const Positions3 x = scene()[0].x_t1;
  const std::vector<std::function<void(LoadedScene&)>> calls = {
      [&](LoadedScene& loaded) { loaded.pipeline.scene.add_body(desc_of(more)); },
      [&](LoadedScene& loaded) { loaded.pipeline.scene.set_positions(loaded.ids[0], x); },
      [](LoadedScene& loaded) { loaded.pipeline.detect(); },
  };
  for (const auto& call : calls) {
    for_every_allocation([&](std::uint64_t n) {
      LoadedScene loaded = fresh();
      bool has_failed = false;
      bool has_leaked = false;
      {
        const FailingAllocation failing(n, /*for_good=*/true);
        try {
          call(loaded);
        } catch (const OutOfMemory&) {
        } catch (const std::bad_alloc&) {
          has_leaked = true;
        }
        has_failed = failing.has_failed();
      }
      EXPECT_FALSE(has_leaked) << "allocation " << n;
      return has_failed && !HasFailure();
    });
  }
}

TEST(FailedQueries, gather_contacts) {
  softcd::Scene bodies(SceneOptions{Backend::cpu});
  const SceneBody ball = still(icosphere(1, 0.3), everything(0.1F));
  bodies.set_positions(bodies.add_body(desc_of(ball)), ball.x_t1);
  Query query(bodies, test_options(Detection::dcd));
  const std::size_t count = query.detect().size();
  EXPECT_GT(count, 0U);
  for_every_allocation([&](std::uint64_t n) {
    bool has_failed = false;
    {
      const FailingAllocation failing(n);
      try {
        query.gather_contacts();
      } catch (const OutOfMemory&) {
      }
      has_failed = failing.has_failed();
    }
    return has_failed;
  });
  EXPECT_EQ(query.gather_contacts().size(), count);
}

TEST_P(FailedCalls, remove_body) {
  expect_all_or_nothing([](LoadedScene& loaded) { loaded.pipeline.scene.remove_body(loaded.ids[1]); }, kNothing);
}

TEST_P(FailedCalls, set_settings) {
  expect_all_or_nothing(
      [](LoadedScene& loaded) { loaded.pipeline.scene.set_settings(loaded.ids[1], everything(0.06F)); }, kNothing);
}

TEST_P(FailedCalls, set_ignored_pairs) {
  expect_all_or_nothing(
      [](LoadedScene& loaded) {
        const BodyPair itself = {loaded.ids[0], loaded.ids[0]};
        loaded.pipeline.scene.set_ignored_pairs({&itself, 1});
      },
      kNothing);
}

TEST_P(FailedCalls, set_vertex_filters) {
  const std::vector<VertexFilter> filters(scene()[1].x_t1.size(), {2, 3});
  expect_all_or_nothing([&](LoadedScene& loaded) { loaded.pipeline.scene.set_vertex_filters(loaded.ids[1], filters); },
                        [](LoadedScene& loaded) {
                          BodySettings settings = everything(0.03F);
                          settings.neighbour_rings = 2;
                          loaded.pipeline.scene.set_settings(loaded.ids[0], settings);
                        });
}

TEST_P(FailedCalls, set_rest_positions) {
  const Positions3 x = scene()[1].x_t0;
  expect_all_or_nothing([&](LoadedScene& loaded) { loaded.pipeline.scene.set_rest_positions(loaded.ids[1], x); },
                        [](LoadedScene& loaded) {
                          BodySettings settings = everything(0.03F);
                          settings.rest_distance = 0.05F;
                          loaded.pipeline.scene.set_settings(loaded.ids[1], settings);
                        });
}

// Two ends in double after one in float need more memory.
TEST_P(FailedCalls, set_positions) {
  const Scene bodies = scene();
  std::vector<Vec3f> floats;
  for (const Vec3d& p : bodies[0].x_t1) floats.push_back(vec3_cast<float>(p));
  const Positions3 x_t0 = translated(bodies[0].x_t0, {0.0, 0.0, 0.07});
  std::vector<Contact> after;
  const std::uint64_t failures = for_every_allocation([&](std::uint64_t n) {
    SCOPED_TRACE(testing::Message() << "allocation " << n);
    CollisionPipeline pipeline(test_options(GetParam().detection));
    const BodyId id = pipeline.scene.add_body(desc_of(bodies[0]));
    pipeline.scene.set_positions(id, floats);
    const std::vector<Contact> before = copy_of(pipeline.detect());
    const auto change = [&] { pipeline.scene.set_positions(id, x_t0, bodies[0].x_t1); };
    const bool has_succeeded = succeeds_although(n, change);
    if (!has_succeeded) {
      EXPECT_TRUE(identical(before, pipeline.detect()));
      change();
    }
    const std::vector<Contact> found = copy_of(pipeline.detect());
    EXPECT_FALSE(found.empty());
    EXPECT_TRUE(n == 1 || identical(after, found));
    after = found;
    return !has_succeeded && !HasFailure();
  });
  EXPECT_GE(failures, 2U);
}

// The positions belong to a frame that is gone when the detection has failed.
TEST_P(FailedCalls, detect) {
  const std::vector<Contact> wanted = expected();
  for (const bool is_first : {true, false}) {
    const std::uint64_t failures = for_every_allocation([&](std::uint64_t n) {
      SCOPED_TRACE(testing::Message() << "allocation " << n << (is_first ? " of the first" : " of the second"));
      LoadedScene loaded = fresh();
      if (!is_first) {
        loaded.pipeline.detect();
        // The topology has to be uploaded again.
        loaded.pipeline.scene.remove_body(loaded.pipeline.scene.add_body(desc_of(loaded.scene[2])));
      }
      auto frame = std::make_unique<Scene>(std::move(loaded.scene));
      for (std::size_t b = 0; b < frame->size(); ++b)
        loaded.pipeline.scene.set_positions(loaded.ids[b], (*frame)[b].x_t0, (*frame)[b].x_t1);
      const bool has_succeeded = detects_although(n, loaded.pipeline, wanted);
      frame.reset();
      EXPECT_TRUE(identical(wanted, loaded.pipeline.detect()));
      return !has_succeeded && !HasFailure();
    });
    EXPECT_GT(failures, is_first ? 50U : 10U);
  }
}

TEST_P(FailedCalls, detect_with_filters) {
  const auto filtered = [] {
    Scene bodies = scene();
    bodies[0].settings.neighbour_rings = 3;
    bodies[1].settings.rest_distance = 0.05F;
    LoadedScene loaded = load(bodies, test_options(GetParam().detection));
    loaded.pipeline.scene.set_vertex_filters(loaded.ids[2], std::vector<VertexFilter>(bodies[2].x_t1.size(), {2, 3}));
    loaded.pipeline.scene.set_rest_positions(loaded.ids[1], bodies[1].x_t0);
    loaded.pipeline.scene.set_ignored_pairs(std::vector<BodyPair>{{loaded.ids[0], loaded.ids[0]}});
    return loaded;
  };
  LoadedScene whole = filtered();
  const std::vector<Contact> wanted = copy_of(whole.pipeline.detect());
  EXPECT_FALSE(wanted.empty());
  EXPECT_LT(wanted.size(), expected().size());
  for_every_allocation([&](std::uint64_t n) {
    SCOPED_TRACE(testing::Message() << "allocation " << n);
    LoadedScene loaded = filtered();
    const bool has_succeeded = detects_although(n, loaded.pipeline, wanted);
    EXPECT_TRUE(identical(wanted, loaded.pipeline.detect()));
    return !has_succeeded && !HasFailure();
  });
}

INSTANTIATE_TEST_SUITE_P(Scenes, FailedCalls,
                         testing::Values(Case{Detection::dcd, false}, Case{Detection::ccd, false},
                                         Case{Detection::dcd, true}, Case{Detection::ccd, true}),
                         [](const auto& test) {
                           return std::string(test.param.detection == Detection::dcd ? "dcd" : "ccd") +
                                  (test.param.has_strays ? "_with_strays" : "");
                         });

}  // namespace
}  // namespace softcd::test

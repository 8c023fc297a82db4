#include <gtest/gtest.h>

#include <vector>

#include "failing_allocations.hpp"
#include "handles.hpp"

// Whichever allocation of a call fails, its error code reports it, no exception leaves it, and everything is unchanged.
namespace softcd::test {
namespace {

class FailedCCalls : public TwoTriangles {
 protected:
  /// Makes all calls, without allocations of the test's own. Returns the status of the first function that fails, or
  /// SOFTCD_OK.
  softcd_status call_everything() {
    softcd_query* made_query = nullptr;
    softcd_probe* made_probe = nullptr;
    softcd_body body = SOFTCD_NO_BODY;
    const softcd_positions x = positions(kUpper);
    softcd_status status = softcd_query_create(scene(), nullptr, &made_query);
    const QueryPointer query(made_query);
    if (status == SOFTCD_OK) status = softcd_query_set_pair_filter(made_query, everything_passes, nullptr);
    if (status == SOFTCD_OK) status = softcd_scene_set_log(scene(), nobody_listens, nullptr);
    if (status == SOFTCD_OK) status = softcd_scene_add_body(scene(), kTriangle, 1, 3, &settings_, &body);
    if (status == SOFTCD_OK) status = softcd_scene_set_positions(scene(), body, nullptr, &x);
    if (status == SOFTCD_OK) status = softcd_query_start(made_query, SOFTCD_PAIRS_ALL);
    if (status == SOFTCD_OK) status = softcd_query_wait(made_query, &contacts_, &count_);
    if (status == SOFTCD_OK) status = softcd_probe_create(scene(), SOFTCD_T1, &made_probe);
    const ProbePointer probe(made_probe);
    if (status == SOFTCD_OK) status = softcd_probe_first_hits(made_probe, &kRay, 1, &hits_);
    if (status == SOFTCD_OK) status = ask_about_bodies(made_probe, body);
    if (status == SOFTCD_OK) status = softcd_scene_update_mesh(scene(), body, &kMesh, &settings_, kTriangle, 1);
    if (status == SOFTCD_OK) status = softcd_scene_update_body(scene(), upper_, kTriangle, 1, 3, &settings_);
    if (status == SOFTCD_OK) status = softcd_scene_set_positions(scene(), upper_, nullptr, &x);
    const bool is_gone = body == SOFTCD_NO_BODY || softcd_scene_remove_body(scene(), body) == SOFTCD_OK;
    return is_gone ? status : SOFTCD_ERROR;
  }

  softcd_status ask_about_bodies(softcd_probe* probe, softcd_body body) {
    const softcd_body_pair all = {SOFTCD_NO_BODY, SOFTCD_NO_BODY};
    const softcd_change change = {body, nullptr, 0, kTriangle, 1, nullptr, 0};
    softcd_status status = softcd_probe_set_body_filter(probe, nobody_is_left_out, nullptr);
    if (status == SOFTCD_OK) status = softcd_probe_distances(probe, &all, 1, &distances_);
    if (status == SOFTCD_OK) status = softcd_probe_intersections(probe, &all, 1, &begins_, &intersections_);
    if (status == SOFTCD_OK) status = softcd_probe_has_intersections(probe, nullptr, &has_intersections_);
    if (status == SOFTCD_OK) status = softcd_probe_intersections_after(probe, &change, 1, &begins_, &after_);
    if (status == SOFTCD_OK) status = softcd_probe_capsule_overlaps(probe, &kCapsule, 1, &begins_, &overlaps_);
    if (status == SOFTCD_OK) status = softcd_probe_hull_overlaps(probe, &kHull, 1, &begins_, &overlaps_);
    return status;
  }

  static std::uint32_t nobody_is_left_out(void* /*data*/, softcd_body /*body*/) { return 1; }
  static std::uint32_t everything_passes(void* /*data*/, softcd_body /*a*/, softcd_body /*b*/) { return 1; }
  static void nobody_listens(void* /*data*/, softcd_log_level /*level*/, const char* /*text*/) {}

  static constexpr softcd_mesh kMesh = {sizeof(softcd_mesh), 3, kTriangle, 1, nullptr, 0};
  static constexpr softcd_ray kRay = {{0.3, 0.3, 9}, {0, 0, -1}, 0, 100};
  const softcd_contact* contacts_ = nullptr;
  std::uint64_t count_ = 0;
  static constexpr softcd_capsule kCapsule = {{0.3, 0.3, 9}, {0.3, 0.3, 0}, 0.1};
  static constexpr double kHullPoints[] = {0.3, 0.3, 9, 0.3, 0.3, 0};
  static constexpr softcd_hull kHull = {kHullPoints, 2, 0.1};
  const softcd_ray_hit* hits_ = nullptr;
  const std::uint64_t* begins_ = nullptr;
  const softcd_body_distance* distances_ = nullptr;
  const softcd_intersection* intersections_ = nullptr;
  const softcd_change_intersection* after_ = nullptr;
  const softcd_overlap* overlaps_ = nullptr;
  std::uint32_t has_intersections_ = 0;
};

TEST_F(FailedCCalls, are_out_of_memory_or_do_without) {
  const std::uint64_t failures = for_every_allocation([&](std::uint64_t n) {
    SCOPED_TRACE(testing::Message() << "allocation " << n);
    softcd_status status = SOFTCD_OK;
    bool has_failed = false;
    {
      const FailingAllocation failing(n);
      status = call_everything();
      has_failed = failing.has_failed();
    }
    EXPECT_TRUE(status == SOFTCD_OK || status == SOFTCD_OUT_OF_MEMORY) << status << ": " << softcd_last_error();
    EXPECT_TRUE(status == SOFTCD_OK || has_failed);
    EXPECT_EQ(detect(), 1U);
    return has_failed && !HasFailure();
  });
  EXPECT_GT(failures, 20U);
}

TEST_F(FailedCCalls, scenes_that_cannot_be_made) {
  softcd_scene_options options{};
  ASSERT_EQ(softcd_scene_options_init(&options, sizeof options), SOFTCD_OK);
  options.backend = SOFTCD_BACKEND_CPU;
  const std::uint64_t failures = for_every_allocation([&](std::uint64_t n) {
    softcd_scene* made = scene();
    softcd_status status = SOFTCD_OK;
    {
      const FailingAllocation failing(n);
      status = softcd_scene_create(&options, &made);
    }
    EXPECT_EQ(made == nullptr, status != SOFTCD_OK);
    EXPECT_TRUE(status == SOFTCD_OK || status == SOFTCD_OUT_OF_MEMORY) << softcd_last_error();
    softcd_scene_destroy(made);
    return status != SOFTCD_OK && !HasFailure();
  });
  EXPECT_GT(failures, 1U);
}

// The text of an error cannot be allocated: the code may then be the one for memory.
TEST_F(FailedCCalls, refusals_stay_error_codes) {
  for_every_allocation([&](std::uint64_t n) {
    softcd_status status = SOFTCD_OK;
    bool has_failed = false;
    {
      const FailingAllocation failing(n);
      status = softcd_scene_remove_body(scene(), 99);
      has_failed = failing.has_failed();
    }
    EXPECT_EQ(status, has_failed ? SOFTCD_OUT_OF_MEMORY : SOFTCD_INVALID_INPUT);
    return has_failed && !HasFailure();
  });
}

}  // namespace
}  // namespace softcd::test

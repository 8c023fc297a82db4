#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"

namespace softcd::test {
namespace {

/// Nearly every triangle overlaps a sixth of all others: pairs need more memory than all else. With a large size ratio
/// some are split and some pairs come more than once.
Scene crowd(double size_ratio = 4.0) {
  SoupOptions options;
  options.triangle_count = 1500;
  options.half_extent = 0.2;
  options.largest = 0.15 * size_ratio;
  options.size_ratio = size_ratio;
  options.seed = 8;
  const Mesh mesh = triangle_soup(options);
  return {moving(mesh, scattered(mesh, 0.002, 9), everything(0.0001F))};
}

Outcome detect_within(std::uint64_t limit, Detection detection, double size_ratio = 4.0) {
  PipelineOptions options = test_options(detection);
  options.memory_limit = limit;
  options.lambda = size_ratio > 4.0 ? 1.2F : 1.8F;
  return outcome_of(crowd(size_ratio), options);
}

constexpr std::uint64_t kPlenty = 1ULL << 40;

class MemoryLimit : public testing::TestWithParam<Detection> {};

TEST_P(MemoryLimit, changes_the_parts_but_not_the_contacts) {
  for (const double size_ratio : {4.0, 12.0}) {
    const Outcome unlimited = detect_within(0, GetParam(), size_ratio);
    const Outcome plenty = detect_within(kPlenty, GetParam(), size_ratio);
    ASSERT_GT(unlimited.contacts.size(), 50U);
    EXPECT_EQ(unlimited.statistics.flagged_pairs > 0, size_ratio > 4.0);
    EXPECT_EQ(plenty.statistics.chunks, 1U);
    EXPECT_TRUE(identical(unlimited.contacts, plenty.contacts));
    for (const double share : {0.9, 0.75, 0.6}) {
      const auto limit = static_cast<std::uint64_t>(share * static_cast<double>(plenty.statistics.peak_bytes));
      const Outcome limited = detect_within(limit, GetParam(), size_ratio);
      EXPECT_GT(limited.statistics.chunks, 1U);
      EXPECT_LE(limited.statistics.peak_bytes, limit);
      EXPECT_TRUE(identical(unlimited.contacts, limited.contacts));
      EXPECT_EQ(limited.statistics.triangle_pairs, unlimited.statistics.triangle_pairs);
      EXPECT_EQ(limited.statistics.vt_candidates, unlimited.statistics.vt_candidates);
      EXPECT_EQ(limited.statistics.ee_candidates, unlimited.statistics.ee_candidates);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, MemoryLimit, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& test) { return test.param == Detection::dcd ? "dcd" : "ccd"; });

TEST(MemoryLimitErrors, a_limit_that_no_parts_can_meet_is_an_error_that_names_it) {
  PipelineOptions options = test_options(Detection::dcd);
  options.memory_limit = 100'000;
  LoadedScene loaded = load(crowd(), options);
  try {
    loaded.pipeline.detect();
    FAIL() << "not enough for the triangles alone";
  } catch (const OutOfMemory& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("100000"));
    EXPECT_THAT(error.what(), testing::HasSubstr("raise"));
  }
  options.memory_limit = 0;
  loaded.pipeline.set_options(options);
  EXPECT_TRUE(identical(detect_within(0, Detection::dcd).contacts, loaded.pipeline.detect()));
}

TEST(MemoryLimitErrors, a_pipeline_goes_on_when_its_limit_changes) {
  PipelineOptions options = test_options(Detection::ccd);
  const Outcome plenty = detect_within(kPlenty, Detection::ccd);
  LoadedScene loaded = load(crowd(), options);
  options.memory_limit = plenty.statistics.peak_bytes / 10 * 7;
  loaded.pipeline.set_options(options);
  EXPECT_TRUE(identical(plenty.contacts, loaded.pipeline.detect()));
  EXPECT_GT(loaded.pipeline.statistics().chunks, 1U);
  EXPECT_TRUE(identical(plenty.contacts, loaded.pipeline.detect()));
  options.memory_limit = 0;
  loaded.pipeline.set_options(options);
  EXPECT_TRUE(identical(plenty.contacts, loaded.pipeline.detect()));
  EXPECT_EQ(loaded.pipeline.statistics().chunks, 1U);
}

}  // namespace
}  // namespace softcd::test

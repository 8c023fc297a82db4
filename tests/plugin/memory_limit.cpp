#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"

namespace softcd::test {
namespace {

/// Nearly every triangle overlaps a sixth of all others, so pairs need more memory than everything else. With a large
/// size ratio patches are loose, some triangles are split, and some pairs are found more than once.
Scene crowd(double size_ratio = 4.0) {
  SoupOptions options;
  options.triangle_count = size_ratio > 4.0 ? 5000 : 1500;
  options.half_extent = size_ratio > 4.0 ? 0.1 : 0.2;
  options.largest = size_ratio > 4.0 ? 0.3 : 0.6;
  options.size_ratio = size_ratio;
  options.seed = 8;
  const Mesh mesh = triangle_soup(options);
  return {moving(mesh, scattered(mesh, 0.002, 9), everything(0.0001F))};
}

Outcome detect_within(std::uint64_t limit, Detection detection, double size_ratio = 4.0) {
  PipelineOptions options = test_options(detection);
  options.memory_limit = limit;
  options.cell_size_factor = size_ratio > 4.0 ? 1.2F : 1.8F;
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

/// With a limit entries are sorted. Without one the CUDA backend lays them into bins, unless these are too long: here
/// cells have nearly all triangles.
TEST(EntryOrder, is_the_same_however_it_is_made) {
  SoupOptions soup;
  soup.triangle_count = 1500;
  soup.half_extent = 0.02;
  soup.largest = 0.1;
  soup.size_ratio = 2.0;
  const Mesh mesh = triangle_soup(soup);
  const Scene scene = {moving(mesh, scattered(mesh, 0.002, 9), everything(0.0001F))};
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    PipelineOptions options = test_options(detection);
    LoadedScene loaded = load(scene, options);
    options.memory_limit = kPlenty;
    const Outcome sorted = outcome_of(scene, options);
    EXPECT_GT(sorted.statistics.entries, 100 * sorted.statistics.cells);
    ASSERT_GT(sorted.contacts.size(), 1000U);
    for (int look = 0; look < 3; ++look) EXPECT_TRUE(identical(loaded.pipeline.detect(), sorted.contacts));
  }
}

/// With a limit contacts are sorted. Without one they are ordered in runs, unless those are too long: here one edge of
/// the blade meets hundreds of the cloth's.
TEST(ContactOrder, is_the_same_however_it_is_made) {
  const Mesh cloth = grid_cloth(24, 24, 0.04);
  const Mesh blade{{{{0, 1, 2}}}, {{-2.0, 0.03, 0.02}, {2.0, 0.03, 0.01}, {0.0, 3.0, 0.04}}};
  const Scene scene = {still(blade, everything(0.1F)), still(cloth, everything(0.1F))};
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    PipelineOptions options = test_options(detection);
    LoadedScene loaded = load(scene, options);
    options.memory_limit = kPlenty;
    const Outcome sorted = outcome_of(scene, options);
    const auto is_of_longest_edge = [](const Contact& contact) {
      return contact.kind == ContactKind::edge_edge && contact.feature_a == 0;
    };
    EXPECT_GT(std::count_if(sorted.contacts.begin(), sorted.contacts.end(), is_of_longest_edge), 200);
    for (int look = 0; look < 3; ++look) EXPECT_TRUE(identical(loaded.pipeline.detect(), sorted.contacts));
  }
}

TEST(MemoryLimitErrors, a_limit_that_no_parts_can_meet_is_an_error_that_names_it) {
  PipelineOptions options = test_options(Detection::dcd);
  options.memory_limit = 400'000;  // a GPU's copy of the scene takes 205,500
  LoadedScene loaded = load(crowd(), options);
  try {
    loaded.pipeline.detect();
    FAIL() << "not enough for the triangles alone";
  } catch (const OutOfMemory& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("for lists of the cells and pairs"));
    EXPECT_THAT(error.what(), testing::HasSubstr("memory_limit of 400000 bytes, "));
    EXPECT_THAT(error.what(), testing::HasSubstr("bytes with what is held already"));
    EXPECT_THAT(error.what(), testing::HasSubstr("raise"));
  }
  options.memory_limit = 0;
  loaded.pipeline.set_options(options);
  EXPECT_TRUE(identical(detect_within(0, Detection::dcd).contacts, loaded.pipeline.detect()));
}

TEST(MemoryLimitErrors, the_limit_of_the_detection_that_starts_holds_for_its_topology) {
  PipelineOptions options = test_options(Detection::dcd);
  options.memory_limit = 100'000;
  LoadedScene loaded = load({still(icosphere(1, 0.1), everything(0.001F))}, options);
  loaded.pipeline.detect();
  const Scene more = crowd();
  const BodyId added = loaded.pipeline.scene.add_body(
      {more[0].triangles, static_cast<std::uint32_t>(more[0].x_t1.size()), more[0].settings});
  loaded.pipeline.scene.set_positions(added, more[0].x_t1);
  EXPECT_THROW(loaded.pipeline.detect(), OutOfMemory);
  for (const std::uint64_t limit : {std::uint64_t{0}, kPlenty}) {
    LoadedScene raised = load({still(icosphere(1, 0.1), everything(0.001F))}, options);
    raised.pipeline.detect();
    const BodyId crowded = raised.pipeline.scene.add_body(
        {more[0].triangles, static_cast<std::uint32_t>(more[0].x_t1.size()), more[0].settings});
    raised.pipeline.scene.set_positions(crowded, more[0].x_t1);
    options.memory_limit = limit;
    raised.pipeline.set_options(options);
    options.memory_limit = 100'000;
    EXPECT_GT(raised.pipeline.detect().size(), 50U);
  }
}

TEST(MemoryLimitErrors, a_lowered_limit_holds_at_once) {
  PipelineOptions options = test_options(Detection::dcd);
  LoadedScene loaded = load(crowd(), options);
  const Span<const Contact> found = loaded.pipeline.detect();
  const std::vector<Contact> contacts(found.begin(), found.end());
  options.memory_limit = detect_within(kPlenty, Detection::dcd).statistics.peak_bytes / 10 * 6;
  ASSERT_LT(options.memory_limit, loaded.pipeline.query.statistics().peak_bytes);
  loaded.pipeline.set_options(options);
  EXPECT_TRUE(identical(contacts, loaded.pipeline.detect()));
  EXPECT_LE(loaded.pipeline.query.statistics().peak_bytes, options.memory_limit);
  for (const std::uint64_t limit : {1U, 1000U, 100'000U}) {
    options.memory_limit = limit;
    loaded.pipeline.set_options(options);
    EXPECT_THROW(loaded.pipeline.detect(), OutOfMemory) << limit;
    EXPECT_LE(loaded.pipeline.query.statistics().peak_bytes, limit);
  }
  options.memory_limit = 0;
  loaded.pipeline.set_options(options);
  EXPECT_TRUE(identical(contacts, loaded.pipeline.detect()));
}

/// Triangles that lie on each other, none with a vertex of another: everything touches everything.
Scene heap_of_copies(std::uint32_t count) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    mesh.triangles.push_back({{3 * i, 3 * i + 1, 3 * i + 2}});
    mesh.positions.insert(mesh.positions.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  }
  return {still(mesh, everything(0.01F))};
}

// The contacts of one query must not take the memory of others.
void expect_memory_for_every_user(std::uint64_t limit_before) {
  SceneOptions limited{backend_under_test()};
  limited.memory_limit = limit_before;
  softcd::Scene bodies(limited);
  const auto add = [&](const SceneBody& body) {
    const BodyId id = bodies.add_body({body.triangles, static_cast<std::uint32_t>(body.x_t1.size()), body.settings});
    bodies.set_positions(id, body.x_t1);
    return id;
  };
  const SceneBody copies = heap_of_copies(200)[0];
  const SceneBody ball = still(icosphere(1, 0.1), everything(0.001F));
  const BodyId heap = add(copies);
  add(ball);
  Query all(bodies, test_options(Detection::dcd));
  const std::size_t found = all.detect().size();
  Query few(bodies, test_options(Detection::dcd));
  few.set_pair_filter([&](BodyId a, BodyId b) { return a != heap && b != heap; });
  Probe probe(bodies);
  SceneOptions options = bodies.options();
  options.memory_limit = 2'000'000;
  ASSERT_GT(found * sizeof(Contact), options.memory_limit);
  bodies.set_options(options);
  EXPECT_THROW(all.gather_contacts(), Error) << "they are gone";
  few.detect();
  EXPECT_LE(few.statistics().peak_bytes, options.memory_limit);
  EXPECT_TRUE(probe.first_hit({{0.1, 0.1, 1}, {0, 0, -1}}).has_hit());
}

TEST(MemoryLimitErrors, a_lowered_limit_leaves_every_query_and_probe_its_memory) {
  expect_memory_for_every_user(0);
  expect_memory_for_every_user(1'000'000'000);
}

// Contacts cannot be found in parts. Their memory is known long before all pairs are tested.
TEST(MemoryLimitErrors, contacts_that_no_parts_can_hold_are_refused_early) {
  PipelineOptions options = test_options(Detection::dcd);
  options.memory_limit = 8'000'000;
  LoadedScene loaded = load(heap_of_copies(700), options);
  try {
    loaded.pipeline.detect();
    FAIL() << "not enough for the contacts";
  } catch (const OutOfMemory& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("for the contacts of 700 triangles"));
    EXPECT_THAT(error.what(), testing::ContainsRegex(": [1-9][0-9]* were found so far, [1-9][0-9]* bytes"));
  }
  const Statistics& statistics = loaded.pipeline.query.statistics();
  EXPECT_GT(statistics.peak_bytes, options.memory_limit / 4);
  EXPECT_LE(statistics.peak_bytes, options.memory_limit);
  EXPECT_GT(statistics.chunks, 1U) << "parts were tried";
  // Half of the pairs of patches are first met in an eighth of the tests: 40 on the CPU. On CUDA the lengths that
  // follow from the first lists are known later: 36.
  EXPECT_LT(statistics.chunks, 64U);
  // The CPU repeats stages, also where the list of pairs of patches grows; CUDA repeats detections.
  EXPECT_LT(statistics.reruns, backend_under_test() == Backend::cpu ? 16U : 10U);
}

TEST(MemoryLimitErrors, a_pipeline_goes_on_when_its_limit_changes) {
  PipelineOptions options = test_options(Detection::ccd);
  const Outcome plenty = detect_within(kPlenty, Detection::ccd);
  LoadedScene loaded = load(crowd(), options);
  options.memory_limit = plenty.statistics.peak_bytes / 10 * 7;
  loaded.pipeline.set_options(options);
  EXPECT_TRUE(identical(plenty.contacts, loaded.pipeline.detect()));
  EXPECT_GT(loaded.pipeline.query.statistics().chunks, 1U);
  EXPECT_TRUE(identical(plenty.contacts, loaded.pipeline.detect()));
  options.memory_limit = 0;
  loaded.pipeline.set_options(options);
  EXPECT_TRUE(identical(plenty.contacts, loaded.pipeline.detect()));
  EXPECT_EQ(loaded.pipeline.query.statistics().chunks, 1U);
}

// The memory that a first detection guesses is not given back. Hardly a triangle takes part.
TEST(Memory, of_a_large_scene_is_little_more_than_it_needs) {
  const Mesh large = grid_cloth(520, 520, 1.0);
  BodySettings settings = everything(0.01F);
  settings.self_collision = false;
  const Outcome outcome =
      outcome_of({still(large, settings), still(grid_cloth(2, 2, 1.0), settings)}, test_options(Detection::dcd));
  const auto triangles = static_cast<double>(large.triangles.size());
  ASSERT_GT(triangles, 500000.0);
  EXPECT_GT(outcome.contacts.size(), 0U);
  EXPECT_EQ(outcome.statistics.reruns, 0U);
  EXPECT_LT(static_cast<double>(outcome.statistics.peak_bytes), 1400.0 * triangles);
}

}  // namespace
}  // namespace softcd::test

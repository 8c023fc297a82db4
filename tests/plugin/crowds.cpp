// Scenes with more pairs than 32 bits can count. Memory stays within its limit, and the result is contacts or an error.
// They take half a minute of one core each.

#include <gtest/gtest.h>

#include <cstdint>

#include "scene.hpp"

namespace softcd::test {
namespace {

/// All pairs of these are more than 2^32.
constexpr std::uint32_t kCrowd = 93'000;

/// Parallel triangles one above the other, `gap` apart and none with a vertex of another.
Mesh pile(std::uint32_t count, double gap) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    mesh.triangles.push_back({{3 * i, 3 * i + 1, 3 * i + 2}});
    const double z = gap * i;
    mesh.positions.insert(mesh.positions.end(), {{0, 0, z}, {1, 0, z}, {0, 1, z}});
  }
  return mesh;
}

TEST(Crowds, more_than_2_32_pairs_in_one_cell_are_all_tested) {
  constexpr double kGap = 1e-5;
  Mesh mesh = pile(kCrowd, kGap);
  // Only the last two touch.
  for (std::size_t v = mesh.positions.size() - 3; v < mesh.positions.size(); ++v) mesh.positions[v].z -= 0.9 * kGap;
  const BodySettings settings = everything(0.1F * static_cast<float>(kGap));
  PipelineOptions options = test_options(Detection::dcd);
  options.memory_limit = 200'000'000;
  options.broad_phase = BroadPhase::uniform;  // of single triangles on the CPU, too
  LoadedScene loaded = load({still(mesh, settings)}, options);
  const std::size_t found = loaded.pipeline.detect().size();
  const Statistics& statistics = loaded.pipeline.query.statistics();
  EXPECT_GT(statistics.tests, 1ULL << 32);
  EXPECT_LE(statistics.peak_bytes, options.memory_limit);
  EXPECT_EQ(found, detect_once({still(pile(2, 0.1 * kGap), settings)}, test_options(Detection::dcd)).size());
  EXPECT_GT(found, 6U);
}

TEST(Crowds, more_than_2_32_contacts_are_refused_within_the_limit) {
  PipelineOptions options = test_options(Detection::dcd);
  options.memory_limit = 200'000'000;
  const SceneBody two = still(pile(2, 0.0), everything(0.01F));
  LoadedScene loaded = load({two, still(pile(kCrowd, 0.0), everything(0.01F))}, options);
  EXPECT_THROW(loaded.pipeline.detect(), OutOfMemory);
  EXPECT_LE(loaded.pipeline.query.statistics().peak_bytes, options.memory_limit);
  loaded.pipeline.scene.remove_body(loaded.ids[1]);
  EXPECT_TRUE(identical(loaded.pipeline.detect(), detect_once({two}, test_options(Detection::dcd))));
}

}  // namespace
}  // namespace softcd::test

#include "lanes/features.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cfloat>
#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "each_target.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

/// The positions of a test's vertices.
enum class Input {
  grid,       ///< on few small integers: features that touch, share vertices, are degenerate
  nearby,     ///< anywhere near each other
  tiny,       ///< the same, so small that products underflow
  subnormal,  ///< the same, so small that many are not normal
  huge,       ///< the same, so large that products overflow
  awkward,    ///< on the grid, and now and then at the ends of the range
};

/// Returns a coordinate that a scene may have. Triangles with vertices that are not finite, or beyond 1e37, are left
/// out earlier. With NaN, even the generic functions differ when g++ 13 vectorises them.
float awkward(Random& random) {
  constexpr float kValues[] = {0.0F,    -0.0F,   FLT_TRUE_MIN, -FLT_TRUE_MIN, FLT_MIN, 1.0F + FLT_EPSILON,
                               1.0e37F, -1.0e37F};
  return kValues[random.below(static_cast<std::uint32_t>(std::size(kValues)))];
}

float coordinate(Random& random, Input input) {
  const auto anywhere = [&] { return static_cast<float>(random.uniform(-1.0, 1.0)); };
  switch (input) {
    case Input::nearby:
      return anywhere();
    case Input::tiny:
      return 1e-12F * anywhere();
    case Input::subnormal:
      return 4.0F * FLT_MIN * anywhere();
    case Input::huge:
      return 1e18F * anywhere();
    case Input::awkward:
      if (random.chance(0.05)) return awkward(random);
      break;
    case Input::grid:
      break;
  }
  return static_cast<float>(random.below(5)) - 2.0F;
}

float scale_of(Input input) {
  switch (input) {
    case Input::tiny:
      return 1e-12F;
    case Input::subnormal:
      return 4.0F * FLT_MIN;
    case Input::huge:
      return 1e18F;
    default:
      return 1.0F;
  }
}

float distance(Random& random, Input input) {
  if (input == Input::awkward && random.chance(0.2)) return awkward(random);
  return random.chance(0.4) ? 0.0F : 0.1F * static_cast<float>(1 + random.below(10)) * scale_of(input);
}

constexpr std::uint32_t kVertices = 60;
/// From 0 to the number of candidates that are tested at once.
constexpr std::uint32_t kCounts = cpu::kMostCandidates + 1;

std::vector<Vec3f> random_positions(Random& random, Input input) {
  std::vector<Vec3f> positions(kVertices);
  for (Vec3f& x : positions) {
    x = {coordinate(random, input), coordinate(random, input), coordinate(random, input)};
  }
  return positions;
}

std::vector<FeatureCandidate> random_candidates(Random& random, Input input, const SceneView& settings,
                                                std::uint32_t count) {
  std::vector<FeatureCandidate> candidates(count);
  for (FeatureCandidate& candidate : candidates) {
    for (std::uint32_t& v : candidate.vertices.v) v = random.below(kVertices);
    candidate.reach.margin = distance(random, input);
    candidate.reach.distance = settings.contact_distance(candidate.reach.margin);
  }
  return candidates;
}

struct Tally {
  int kept = 0;
  int left_out = 0;
};

template <ContactKind kKind, bool kSwept>
void expect_the_generic_answer(Input input, const SceneView& settings, Tally& tally) {
  Random random(static_cast<std::uint64_t>(input));
  for (std::uint32_t round = 0; round < 4 * kCounts; ++round) {
    // No memory beyond the last vertex or the last candidate may be read.
    const std::vector<Vec3f> x_t1 = random_positions(random, input);
    std::vector<Vec3f> x_t0 = x_t1;
    for (Vec3f& x : x_t0) {
      if (random.chance(0.5)) x = {coordinate(random, input), coordinate(random, input), coordinate(random, input)};
    }
    const std::uint32_t count = round % kCounts;
    const std::vector<FeatureCandidate> candidates = random_candidates(random, input, settings, count);
    FeatureTest<kKind, kSwept> test{settings};
    test.scene.x_t0 = kSwept ? x_t0.data() : nullptr;
    test.scene.x_t1 = x_t1.data();
    const std::uint64_t bits = cpu::candidates_to_keep(test, candidates.data(), count);
    ASSERT_EQ(bits, cpu::generic::candidates_to_keep(test, candidates.data(), count)) << count << " candidates";
    tally.kept += std::popcount(bits);
    tally.left_out += static_cast<int>(count) - std::popcount(bits);
  }
}

class FeaturesInLanes : public testing::TestWithParam<Input> {
 protected:
  static void expect_the_generic_answers(const SceneView& settings) {
    for_each_target([&] {
      Tally tally;
      expect_the_generic_answer<ContactKind::vertex_triangle, false>(GetParam(), settings, tally);
      expect_the_generic_answer<ContactKind::vertex_triangle, true>(GetParam(), settings, tally);
      expect_the_generic_answer<ContactKind::edge_edge, false>(GetParam(), settings, tally);
      expect_the_generic_answer<ContactKind::edge_edge, true>(GetParam(), settings, tally);
      // There are 4 x 4 x 2080 candidates.
      EXPECT_GT(tally.kept, 500);
      EXPECT_GT(tally.left_out, 500);
    });
  }
};

TEST_P(FeaturesInLanes, answer_as_one_by_one) {
  expect_the_generic_answers({});
}

TEST_P(FeaturesInLanes, conservative_ones_answer_as_one_by_one) {
  SceneView settings;
  settings.is_conservative = true;
  expect_the_generic_answers(settings);
}

TEST_P(FeaturesInLanes, those_of_slabs_answer_as_one_by_one) {
  SceneView settings;
  settings.contact_rule = ContactRule::slab;
  expect_the_generic_answers(settings);
}

std::string name_of(const testing::TestParamInfo<Input>& input) {
  constexpr std::array<const char*, 6> kNames = {"grid", "near", "tiny", "subnormal", "huge", "awkward"};
  return kNames[static_cast<std::size_t>(input.param)];
}

INSTANTIATE_TEST_SUITE_P(Inputs, FeaturesInLanes,
                         testing::Values(Input::grid, Input::nearby, Input::tiny, Input::subnormal, Input::huge,
                                         Input::awkward),
                         name_of);

}  // namespace
}  // namespace softcd::test

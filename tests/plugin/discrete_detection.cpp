#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <tuple>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

struct SoupCase {
  std::uint32_t triangle_count;
  double size_ratio;
  std::uint64_t seed;

  friend std::ostream& operator<<(std::ostream& out, const SoupCase& c) {
    return out << c.triangle_count << " triangles, sizes 1:" << c.size_ratio << ", seed " << c.seed;
  }
};

Mesh soup(const SoupCase& c) {
  SoupOptions options;
  options.triangle_count = c.triangle_count;
  options.size_ratio = c.size_ratio;
  options.half_extent = c.size_ratio > 10.0 ? 2.0 : 3.0;
  options.largest = c.size_ratio > 10.0 ? 3.0 : 0.5;
  options.needle_share = 0.05;
  options.degenerate_share = 0.05;
  options.joined_share = 0.3;
  options.seed = c.seed;
  return triangle_soup(options);
}

class DiscreteSoup : public testing::TestWithParam<SoupCase> {};

TEST_P(DiscreteSoup, one_body_with_itself) {
  const Scene scene{still(soup(GetParam()), everything(0.02F))};
  EXPECT_GT(expect_discrete_contacts(scene, test_options(Detection::dcd)), 0U);
}

TEST_P(DiscreteSoup, without_subdivision) {
  const Scene scene{still(soup(GetParam()), everything(0.02F))};
  PipelineOptions options = test_options(Detection::dcd);
  options.subdivision = false;
  EXPECT_GT(expect_discrete_contacts(scene, options), 0U);
}

TEST_P(DiscreteSoup, uniform_grid) {
  const Scene scene{still(soup(GetParam()), everything(0.02F))};
  EXPECT_GT(expect_discrete_contacts(scene, test_options(Detection::dcd, BroadPhase::uniform)), 0U);
}

TEST_P(DiscreteSoup, four_bodies_with_margins_of_their_own) {
  Scene scene;
  for (std::uint64_t i = 0; i < 4; ++i) {
    SoupCase part = GetParam();
    part.triangle_count = part.triangle_count / 4 + 1;
    part.seed += 100 * (i + 1);
    BodySettings settings = everything(0.01F * static_cast<float>(i));
    settings.self_collision = i % 2 == 0;
    settings.features = {i != 1, i != 2};
    scene.push_back(still(soup(part), settings));
  }
  EXPECT_GT(expect_discrete_contacts(scene, test_options(Detection::dcd)), 0U);
}

INSTANTIATE_TEST_SUITE_P(Sizes, DiscreteSoup,
                         testing::Values(SoupCase{200, 1.0, 1}, SoupCase{600, 3.0, 2}, SoupCase{1000, 30.0, 3},
                                         SoupCase{2000, 1000.0, 4}, SoupCase{1000, 10000.0, 5}));

TEST(DiscreteDetection, every_cell_size_factor_gives_the_same_contacts) {
  const Scene scene{still(soup({800, 100.0, 6}), everything(0.01F))};
  const std::vector<Contact> expected = detect_once(scene, test_options(Detection::dcd));
  ASSERT_FALSE(expected.empty());
  for (const float factor : {0.8F, 1.0F, 1.2F, 1.5F, 1.8F, 2.1F, 2.4F}) {
    for (const bool subdivision : {true, false}) {
      PipelineOptions options = test_options(Detection::dcd);
      options.cell_size_factor = factor;
      options.subdivision = subdivision;
      EXPECT_TRUE(identical(expected, detect_once(scene, options))) << "cell_size_factor " << factor;
    }
  }
}

TEST(DiscreteDetection, crumpled_cloth) {
  const Mesh cloth = crumpled_cloth(40, 30, 0.125, 0.03, 1);
  const Scene scene{still(cloth, everything(0.02F))};
  EXPECT_GT(expect_discrete_contacts(scene, test_options(Detection::dcd)), 1000U);
}

TEST(DiscreteDetection, closed_surfaces_in_each_other) {
  const BodySettings settings = everything(0.01F);
  const Scene scene{still(icosphere(3, 1.0), settings), still(torus(1.0, 0.3, 40, 16), settings),
                    still(tube(0.9, 3.0, 24, 30), settings), still(moved(icosphere(1, 2.0), {0.5, 0, 0}), settings)};
  EXPECT_GT(expect_discrete_contacts(scene, test_options(Detection::dcd)), 100U);
}

TEST(DiscreteDetection, margins_from_zero_to_the_scene) {
  const Mesh mesh = soup({150, 20.0, 7});
  for (const float margin : {0.0F, 1e-6F, 1e-3F, 0.1F, 1.0F, 10.0F}) {
    const Scene scene{still(mesh, everything(margin))};
    SCOPED_TRACE(margin);
    expect_discrete_contacts(scene, test_options(Detection::dcd));
  }
}

TEST(DiscreteDetection, only_positions_at_t1_count) {
  Mesh mesh = soup({300, 10.0, 8});
  const Scene still_scene{still(mesh, everything(0.02F))};
  Scene moving_scene = still_scene;
  moving_scene[0].x_t0 = jittered(mesh.positions, 0.5, 3);
  EXPECT_EQ(features_of(detect_once(still_scene, test_options(Detection::dcd))),
            features_of(detect_once(moving_scene, test_options(Detection::dcd))));
}

TEST(DiscreteDetection, motion_widens_the_margin_of_vertices_against_other_bodies) {
  Scene scene;
  for (const std::uint64_t seed : {9U, 10U}) {
    const Mesh mesh = soup({300, 20.0, seed});
    Positions3 x_t0 = jittered(mesh.positions, 0.25, seed - 5);
    snap_to_grid(x_t0, 17);
    scene.push_back({mesh.triangles, x_t0, mesh.positions, everything(0.005F)});
  }
  PipelineOptions options = test_options(Detection::dcd);
  const std::size_t narrow = expect_discrete_contacts(scene, options);
  PipelineOptions wide_options = options;
  wide_options.motion_margin = 0.5F;
  DiscreteRules rules;
  rules.motion_margin = 0.5;
  EXPECT_GT(expect_discrete_contacts(scene, wide_options, rules), narrow);

  scene.pop_back();
  EXPECT_EQ(features_of(detect_once(scene, wide_options)), features_of(detect_once(scene, options)));
}

// In float32 arithmetic on coordinates of a few units, the square of a distance has an error of some 2^-24 of the
// squared lengths. A distance of about the margin is known to this much.
TEST(DiscreteDetection, fast_agrees_outside_float_rounding) {
  const Scene scene{still(soup({800, 30.0, 10}), everything(0.02F))};
  PipelineOptions options = test_options(Detection::dcd);
  options.accuracy = Accuracy::fast;
  DiscreteRules rules;
  rules.absolute_band = 64.0 * 0x1p-24;
  const Difference difference = compare(discrete_verdicts(scene, rules), features_of(detect_once(scene, options)));
  EXPECT_TRUE(agrees(difference)) << describe(difference);
}

// More contacts of one edge than runs order, so that all are sorted by digits of 11 bits: those of the features'
// numbers end where a digit does, and the kind is in the next one.
TEST(DiscreteDetection, orders_a_heap_by_kind_and_features) {
  Mesh heap;
  const auto add = [&heap](double x, double z) {
    const auto v = static_cast<std::uint32_t>(heap.positions.size());
    heap.triangles.push_back({{v, v + 1, v + 2}});
    heap.positions.insert(heap.positions.end(), {{x, 0, z}, {x + 1, 0, z}, {x, 1, z}});
  };
  for (int i = 0; i < 48; ++i) add(0, 0.001 * i);
  for (int i = 0; i < 320; ++i) add(2 + 2 * i, 0);
  ASSERT_GT(heap.positions.size(), 1U << 10);
  ASSERT_LT(heap.positions.size(), 1U << 11);
  const Scene scene{still(heap, everything(0.1F))};
  const std::vector<Contact> contacts = detect_once(scene, test_options(Detection::dcd));
  ASSERT_GT(contacts.size(), 10'000U);
  const auto is_before = [](const Contact& a, const Contact& b) {
    return std::tie(a.kind, a.feature_a, a.feature_b) < std::tie(b.kind, b.feature_a, b.feature_b);
  };
  EXPECT_TRUE(std::is_sorted(contacts.begin(), contacts.end(), is_before));
}

}  // namespace
}  // namespace softcd::test

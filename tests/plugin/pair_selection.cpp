#include "pair_selection.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "random.hpp"

namespace softcd::test {
namespace {

/// The content of a selection, by its bodies' numbers.
struct Chosen {
  std::set<IndexPair> pairs;
  std::map<std::uint32_t, std::vector<float>> partner_boxes;  ///< of those with partners
  bool vertex_triangle = false, edge_edge = false;

  friend bool operator==(const Chosen&, const Chosen&) = default;
};

/// Extents are multiples of an eighth, and the sums of two margins are not: boxes never touch, wherever roundings are.
constexpr double kGrid = 0.125;
constexpr float kMargin = 0.03125F;

double on_grid(double x) {
  return kGrid * std::round(x / kGrid);
}

void place_at_random(Body& body, double half_room, Random& random) {
  StepSurvey survey;
  const Vec3d at = random.in_box(half_room);
  for (EndSurvey* end : {&survey.t0, &survey.t1}) {
    for (int corner = 0; corner < 2; ++corner) {
      const Vec3d p = at + random.in_box(0.6);
      end->extent.extend(Vec3d{on_grid(p.x), on_grid(p.y), on_grid(p.z)});
    }
  }
  body.positions.set(Positions(), Positions());
  body.positions.set_survey(survey);
}

BodySettings random_settings(std::uint32_t batch_count, Random& random) {
  BodySettings settings;
  settings.margin = kMargin;
  settings.filter_group = 1U << random.below(3);
  settings.filter_mask = random.chance(0.5) ? 0xFFFFFFFFU : random.below(8);
  settings.self_collision = random.chance(0.5);
  settings.kinematic = random.chance(0.2);
  settings.features = {random.chance(0.8), random.chance(0.8)};
  settings.batch = random.below(batch_count);
  return settings;
}

std::vector<Body> random_bodies(std::uint32_t count, double half_room, std::uint32_t batch_count, Random& random) {
  std::vector<Body> bodies(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    bodies[i].id = BodyId{3 * i + 1};
    bodies[i].settings = random_settings(batch_count, random);
    bodies[i].neighbours.are_listed = random.chance(0.5);
    bodies[i].last_change = random.below(4);
    if (random.chance(0.9)) place_at_random(bodies[i], half_room, random);
  }
  return bodies;
}

Extent extent_of_step(const Body& body, const Selecting& selecting) {
  Extent extent;
  if (!body.positions.are_set()) return extent;
  if (selecting.t0) extent.extend(body.positions.survey().t0.extent);
  if (selecting.t1) extent.extend(body.positions.survey().t1.extent);
  return extent;
}

bool are_near(const Extent& a, const Extent& b, double distance) {
  const auto meet = [&](double a_lo, double a_hi, double b_lo, double b_hi) {
    return a_lo - distance <= b_hi && b_lo - distance <= a_hi;
  };
  return !a.is_empty() && !b.is_empty() && meet(a.lo.x, a.hi.x, b.lo.x, b.hi.x) &&
         meet(a.lo.y, a.hi.y, b.lo.y, b.hi.y) && meet(a.lo.z, a.hi.z, b.lo.z, b.hi.z);
}

std::vector<float> grown(const Extent& extent) {
  const auto distance = static_cast<double>(kMargin);
  std::vector<float> corners;
  for (const double x : {extent.lo.x - distance, extent.lo.y - distance, extent.lo.z - distance, extent.hi.x + distance,
                         extent.hi.y + distance, extent.hi.z + distance}) {
    corners.push_back(static_cast<float>(x));
  }
  return corners;
}

Chosen by_brute_force(const std::vector<Body>& bodies, const Selecting& selecting, const PairFilter& filter) {
  Chosen chosen;
  std::vector<Extent> partners(bodies.size());
  for (std::uint32_t a = 0; a < bodies.size(); ++a) {
    for (std::uint32_t b = a; b < bodies.size(); ++b) {
      const BodySettings& s = bodies[a].settings;
      const BodySettings& t = bodies[b].settings;
      const Extent extent_a = extent_of_step(bodies[a], selecting);
      const Extent extent_b = extent_of_step(bodies[b], selecting);
      const bool vertex_triangle =
          s.features.vertex_triangle && t.features.vertex_triangle && selecting.features.vertex_triangle;
      const bool edge_edge = s.features.edge_edge && t.features.edge_edge && selecting.features.edge_edge;
      const bool is_wanted =
          a == b ? s.self_collision
                 : s.batch == t.batch && (s.filter_group & t.filter_mask) != 0 && (t.filter_group & s.filter_mask) != 0;
      const bool is_new = std::max(bodies[a].last_change, bodies[b].last_change) > selecting.changed_since;
      if (!is_wanted || (s.kinematic && t.kinematic) || !(vertex_triangle || edge_edge) || !is_new) continue;
      if (!are_near(extent_a, extent_b, 2.0 * static_cast<double>(kMargin))) continue;
      if (filter && !filter(bodies[a].id, bodies[b].id)) continue;
      chosen.pairs.insert({a, b});
      chosen.vertex_triangle |= vertex_triangle;
      chosen.edge_edge |= edge_edge;
      partners[a].extend(extent_b);
      partners[b].extend(extent_a);
    }
  }
  for (const auto& [a, b] : chosen.pairs) {
    chosen.partner_boxes[a] = grown(partners[a]);
    chosen.partner_boxes[b] = grown(partners[b]);
  }
  return chosen;
}

/// Returns the content of a selection, and checks that each pair is in both bodies' rows, in order and once.
Chosen in_rows(const PairSelection& selection) {
  Chosen chosen;
  std::uint64_t pair_count = 0;
  std::uint64_t self_count = 0;
  for (std::uint32_t a = 0; a < selection.bodies.size(); ++a) {
    for (std::uint64_t i = selection.partner_begin[a]; i < selection.partner_begin[a + 1]; ++i) {
      const std::uint32_t b = selection.partners[i];
      EXPECT_TRUE(i == selection.partner_begin[a] || selection.partners[i - 1] < b);
      if (a <= b) {
        chosen.pairs.insert({a, b});
        ++(a == b ? self_count : pair_count);
      } else {
        EXPECT_EQ(chosen.pairs.count({b, a}), 1U);
      }
      const Box& box = selection.bodies[a].partner_box;
      chosen.partner_boxes[a] = {box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z};
    }
  }
  EXPECT_EQ(selection.partners.size(), 2 * pair_count + self_count);
  EXPECT_EQ(selection.pair_count, pair_count);
  EXPECT_EQ(selection.self_count, self_count);
  chosen.vertex_triangle = selection.vertex_triangle;
  chosen.edge_edge = selection.edge_edge;
  return chosen;
}

/// Expects equal selections, with boxes rounded outward.
void expect_same(const Chosen& found, const Chosen& expected) {
  EXPECT_EQ(found.pairs, expected.pairs);
  EXPECT_EQ(found.vertex_triangle, expected.vertex_triangle);
  EXPECT_EQ(found.edge_edge, expected.edge_edge);
  ASSERT_EQ(found.partner_boxes.size(), expected.partner_boxes.size());
  for (const auto& [body, corners] : expected.partner_boxes) {
    const std::vector<float>& found_corners = found.partner_boxes.at(body);
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_NEAR(found_corners[i], corners[i], 1e-4);
      EXPECT_TRUE(i < 3 ? found_corners[i] <= corners[i] : found_corners[i] >= corners[i]);
    }
  }
}

class PairSelectionOfMany : public testing::TestWithParam<std::uint32_t> {};

// One selector is used for all of it: earlier calls must not matter.
TEST_P(PairSelectionOfMany, is_that_of_brute_force) {
  const std::uint32_t batch_count = GetParam();
  Random random(batch_count);
  PairSelector selector;
  std::size_t pairs = 0;
  for (int round = 0; round < 12; ++round) {
    const std::uint32_t count = round % 4 == 3 ? random.below(20) : 150;
    std::vector<Body> bodies = random_bodies(count, 3.0, batch_count, random);
    for (int step = 0; step < 4; ++step) {
      Selecting selecting;
      selecting.t0 = step % 2 == 0;
      selecting.t1 = step % 3 != 0 || !selecting.t0;
      selecting.features = {round % 3 != 1, round % 3 != 2};
      selecting.changed_since = round % 2 == 0 ? 0 : random.below(4);
      PairFilter filter;
      if (round % 3 == 0) filter = [](BodyId a, BodyId b) { return (a.value + b.value) % 5 != 0; };
      const Chosen expected = by_brute_force(bodies, selecting, filter);
      expect_same(in_rows(selector.select(bodies, {0, 0, 0}, selecting, filter)), expected);
      pairs += expected.pairs.size();
      for (Body& body : bodies) {
        if (random.chance(0.3) && body.positions.are_set()) place_at_random(body, 3.0, random);
      }
    }
  }
  EXPECT_GT(pairs, 100U);
}

INSTANTIATE_TEST_SUITE_P(Batches, PairSelectionOfMany, testing::Values(1U, 2U, 30U),
                         [](const auto& test) { return std::to_string(test.param); });

TEST(PairSelection, asks_the_filter_about_every_pair_once_in_order) {
  Random random(3);
  std::vector<Body> bodies = random_bodies(60, 1.0, 2, random);
  Selecting selecting;
  selecting.t1 = true;
  selecting.features = {true, true};
  bodies[0].last_change = 1;
  std::vector<IndexPair> asked;
  const PairFilter filter = [&](BodyId a, BodyId b) {
    asked.emplace_back(a.value, b.value);
    return true;
  };
  PairSelector selector;
  const PairSelection& selection = selector.select(bodies, {0, 0, 0}, selecting, filter);
  EXPECT_EQ(asked.size(), selection.pair_count + selection.self_count);
  EXPECT_GT(asked.size(), 30U);
  EXPECT_TRUE(std::is_sorted(asked.begin(), asked.end()));
}

// So many bodies are surveyed by several threads.
TEST(PairSelection, of_many_bodies_is_that_of_each_batch) {
  constexpr std::uint32_t kBatches = 3000;
  Random random(5);
  std::vector<Body> bodies(std::size_t{2} * kBatches);
  for (std::uint32_t b = 0; b < bodies.size(); ++b) {
    bodies[b].id = BodyId{b};
    bodies[b].settings.margin = kMargin;
    bodies[b].settings.batch = b / 2;
    bodies[b].settings.self_collision = false;
    bodies[b].last_change = 1;
    place_at_random(bodies[b], b / 2 % 2 == 0 ? 0.0 : 50.0, random);
  }
  Selecting selecting;
  selecting.t1 = true;
  selecting.features = {true, true};
  PairSelector selector;
  const PairSelection& selection = selector.select(bodies, {0, 0, 0}, selecting, {});
  std::uint64_t expected = 0;
  for (std::uint32_t a = 0; a < bodies.size(); a += 2) {
    const bool meet = are_near(extent_of_step(bodies[a], selecting), extent_of_step(bodies[a + 1], selecting),
                               2.0 * static_cast<double>(kMargin));
    expected += meet ? 1 : 0;
    ASSERT_EQ(selection.partner_begin[a + 1] - selection.partner_begin[a], meet ? 1U : 0U);
    ASSERT_TRUE(!meet || selection.partners[selection.partner_begin[a]] == a + 1);
  }
  EXPECT_EQ(selection.pair_count, expected);
  EXPECT_GT(expected, kBatches / 6);
}

TEST(PairSelection, that_is_known_serves_no_other_options) {
  Random random(7);
  const std::vector<Body> bodies = random_bodies(60, 1.0, 1, random);
  constexpr std::uint64_t kBodiesNumber = 1;
  PairSelector selector;
  for (int round = 0; round < 4; ++round) {
    Selecting selecting;
    selecting.t1 = true;
    selecting.features = {round != 1, round != 2};
    expect_same(in_rows(selector.select(bodies, {0, 0, 0}, selecting, {}, kBodiesNumber)),
                by_brute_force(bodies, selecting, {}));
  }
}

// Two bodies that are further apart than their margins together, and less than twice as far.
TEST(PairSelection, reaches_as_far_as_the_factor_of_distances_says) {
  std::vector<Body> bodies(2);
  for (std::uint32_t b = 0; b < 2; ++b) {
    bodies[b].id = BodyId{b};
    bodies[b].settings.margin = kMargin;
    bodies[b].settings.self_collision = false;
    bodies[b].last_change = 1;
    StepSurvey survey;
    survey.t1.extent.extend(Vec3d{3.2 * static_cast<double>(kMargin) * b, 0, 0});
    bodies[b].positions.set(Positions(), Positions());
    bodies[b].positions.set_survey(survey);
  }
  for (const float factor : {1.0F, 2.0F}) {
    Selecting selecting;
    selecting.t1 = true;
    selecting.features = {true, true};
    selecting.distance_factor = factor;
    EXPECT_EQ(PairSelector().select(bodies, {0, 0, 0}, selecting, {}).pair_count, factor > 1.0F ? 1U : 0U);
  }
}

}  // namespace
}  // namespace softcd::test

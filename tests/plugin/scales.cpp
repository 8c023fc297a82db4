#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "queries.hpp"
#include "query_detector.hpp"

// Scaling by powers of two keeps the contacts, also at scales where float32 would need subnormal numbers or overflow.
namespace softcd::test {
namespace {

constexpr int kGridBits = 10;

struct Rules {
  const char* name;
  Detection detection;
  ContactRule contact_rule;
  float margin;
  float motion_margin;
};

std::ostream& operator<<(std::ostream& out, const Rules& rules) {
  return out << rules.name;
}

constexpr std::array kRules{Rules{"dcd", Detection::dcd, ContactRule::distance, 0.03125F, 0.0F},
                            Rules{"slab", Detection::dcd, ContactRule::slab, 0.03125F, 0.0F},
                            Rules{"motion_margin", Detection::dcd, ContactRule::distance, 0.0078125F, 0.25F},
                            Rules{"ahead", Detection::dcd, ContactRule::ahead, 0.0078125F, 2.0F},
                            Rules{"ccd", Detection::ccd, ContactRule::distance, 0.0F, 0.0F},
                            Rules{"ccd_with_margin", Detection::ccd, ContactRule::distance, 0.03125F, 0.0F}};

/// Returns the scene with every coordinate and margin times 2^exponent.
Scene scene_at(const Rules& rules, int exponent) {
  Scene scene;
  for (std::uint64_t i = 0; i < 2; ++i) {
    SoupOptions options;
    options.triangle_count = 120;
    options.half_extent = 1.0;
    options.joined_share = 0.4;
    options.grid_bits = kGridBits;
    options.seed = 40 + i;
    const Mesh mesh = triangle_soup(options);
    Positions3 end = jittered(mesh.positions, 0.125, i);
    snap_to_grid(end, kGridBits);
    scene.push_back(moving(mesh, end, everything(std::ldexp(rules.margin, exponent))));
    for (Positions3* x : {&scene.back().x_t0, &scene.back().x_t1}) *x = contracted(*x, std::ldexp(1.0, exponent));
  }
  return scene;
}

PipelineOptions options_for(const Rules& rules, Accuracy accuracy) {
  PipelineOptions options = test_options(rules.detection);
  options.accuracy = accuracy;
  options.contact_rule = rules.contact_rule;
  options.motion_margin = rules.motion_margin;
  return options;
}

class Scales : public testing::TestWithParam<Rules> {};

INSTANTIATE_TEST_SUITE_P(Rules, Scales, testing::ValuesIn(kRules), [](const auto& test) { return test.param.name; });

TEST_P(Scales, from_1e_minus_30_to_1e30_have_the_same_contacts) {
  const Rules& rules = GetParam();
  for (const Accuracy accuracy : {Accuracy::fast, Accuracy::precise, Accuracy::conservative}) {
    const Outcome at_one = outcome_of(scene_at(rules, 0), options_for(rules, accuracy));
    const std::vector<FeaturePair> expected = features_of(at_one.contacts);
    ASSERT_GT(expected.size(), 100U);
    if (rules.detection == Detection::dcd && rules.contact_rule == ContactRule::distance) {
      DiscreteRules judged;
      judged.motion_margin = static_cast<double>(rules.motion_margin);
      judged.absolute_band = accuracy == Accuracy::fast ? 1e-6 : 1e-12;
      const Difference difference = compare(discrete_verdicts(scene_at(rules, 0), judged), expected);
      EXPECT_TRUE(agrees(difference)) << describe(difference);
    }
    for (int exponent = -100; exponent <= 100; exponent += 10) {
      const Outcome outcome = outcome_of(scene_at(rules, exponent), options_for(rules, accuracy));
      ASSERT_EQ(features_of(outcome.contacts), expected)
          << "2^" << exponent << ", accuracy " << static_cast<int>(accuracy);
      for (const Contact& contact : outcome.contacts) {
        ASSERT_NEAR(squared_norm(vec3_cast<double>(contact.normal)), 1.0, 1e-6) << "2^" << exponent;
      }
      EXPECT_LE(outcome.statistics.tests, 2 * at_one.statistics.tests) << "2^" << exponent;
    }
  }
}

/// Returns a point straight above a triangle, or an edge above an edge, of about that size, moving away.
Query small_features_apart(Random& random, ContactKind kind, double size, double distance) {
  Query query{kind, {}};
  Rows& rows = query.rows;
  const bool is_vertex = kind == ContactKind::vertex_triangle;
  for (std::size_t i = 0; i < 4; ++i) rows[i] = size * random.in_box(1.0);
  if (is_vertex) rows[0] = (1.0 / 3.0) * (rows[1] + rows[2] + rows[3]);
  const Vec3d plane =
      is_vertex ? cross(rows[2] - rows[1], rows[3] - rows[1]) : cross(rows[1] - rows[0], rows[3] - rows[2]);
  const Vec3d offset = distance * unit_vector(plane);
  for (std::size_t i = 0; i < 4; ++i) {
    const bool is_a = i < (is_vertex ? 1U : 2U);
    rows[i + 4] = vec3_cast<double>(vec3_cast<float>(is_a ? rows[i] + 1.5 * offset : rows[i]));
    rows[i] = vec3_cast<double>(vec3_cast<float>(is_a ? rows[i] + offset : rows[i]));
  }
  return query;
}

// Edges far shorter than the margin: products of the two fit float32 where their squares do not.
TEST(TinyFeatures, within_the_margin_are_found) {
  Random random(8);
  for (const ContactKind kind : {ContactKind::vertex_triangle, ContactKind::edge_edge}) {
    for (double exponent = -6.0; exponent > -16.0; exponent -= 0.25) {
      for (const double distance : {1.0, 1.7e-5, 1e-12}) {
        for (int i = 0; i < 4; ++i) {
          const Query query = small_features_apart(random, kind, std::pow(10.0, exponent), distance);
          for (const Detection detection : {Detection::dcd, Detection::ccd}) {
            const std::size_t end = detection == Detection::dcd ? 4 : 0;
            const double nearest = std::sqrt(squared_distance(kind, std::span<const Vec3d, 4>(&query.rows[end], 4)));
            for (const Accuracy accuracy : {Accuracy::fast, Accuracy::precise, Accuracy::conservative}) {
              PipelineOptions options = test_options(detection);
              options.accuracy = accuracy;
              ASSERT_TRUE(QueryDetector(kind, options, static_cast<float>(nearest * 1.02)).detect(query))
                  << "edges of 1e" << exponent << ", " << nearest << " apart, detection " << static_cast<int>(detection)
                  << ", accuracy " << static_cast<int>(accuracy);
            }
          }
        }
      }
    }
  }
}

// A vertex that moves by `move` and ends at some height, in moves, over a slanted triangle.
TEST(MotionMargin, counts_moves_of_any_length) {
  for (int exponent = -120; exponent <= 116; exponent += 4) {
    const double move = std::ldexp(1.0, exponent);
    for (const double height : {1.75, 2.5}) {
      const Mesh floor{
          {{{0, 1, 2}}},
          {{12 * move, -6 * move, -6 * move}, {-6 * move, 12 * move, -6 * move}, {-6 * move, -6 * move, 12 * move}}};
      const double x = std::sqrt(1.0 / 3.0) * height * move;
      const Mesh point{{{{0, 0, 0}}}, {{x - move, x, x}}};
      const Scene scene{still(floor, everything()), moving(point, {{x, x, x}}, everything())};
      for (const Accuracy accuracy : {Accuracy::fast, Accuracy::precise, Accuracy::conservative}) {
        PipelineOptions options = test_options(Detection::dcd);
        options.accuracy = accuracy;
        options.motion_margin = 2.0F;
        EXPECT_EQ(detect_once(scene, options).size(), height < 2.0 ? 1U : 0U)
            << "move 2^" << exponent << ", height " << height;
      }
    }
  }
}

}  // namespace
}  // namespace softcd::test

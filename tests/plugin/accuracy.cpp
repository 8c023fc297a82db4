#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "expectations.hpp"
#include "queries.hpp"
#include "query_detector.hpp"

// Checks the guarantees of docs/measured/accuracy.md, through the public interface and against exact arithmetic.
namespace softcd::test {
namespace {

constexpr std::array kKinds{ContactKind::vertex_triangle, ContactKind::edge_edge};

PipelineOptions options_for(Detection detection, Accuracy accuracy) {
  PipelineOptions options = test_options(detection);
  options.accuracy = accuracy;
  return options;
}

const char* name_of(Accuracy accuracy) {
  constexpr std::array kNames{"fast", "precise", "conservative"};
  return kNames[static_cast<std::size_t>(accuracy)];
}

struct Tally {
  int touching = 0, missed = 0, late = 0, far_early = 0;
  double latest = 0.0;
};

/// Continuous detections of `count` queries of every family and kind, without margins.
Tally tally(Accuracy accuracy, bool is_single, int count) {
  Tally all;
  for (const ContactKind kind : kKinds) {
    QueryDetector detector(kind, options_for(Detection::ccd, accuracy));
    for (std::uint32_t family = 0; family < kFamilies; ++family) {
      Random random(family + 900);
      for (int i = 0; i < count; ++i) {
        const Query query = make_query(random, kind, static_cast<Family>(family), is_single);
        const std::optional<TimeBracket> truth = first_contact(query);
        if (!truth) continue;
        ++all.touching;
        const std::optional<Contact> contact = detector.detect(query);
        if (!contact) {
          ++all.missed;
          continue;
        }
        const auto time = static_cast<double>(contact->time_of_impact);
        all.late += time > truth->hi ? 1 : 0;
        all.latest = std::max(all.latest, time - truth->hi);
        all.far_early += time < truth->lo - 1e-3 ? 1 : 0;
      }
    }
  }
  std::printf("%d touch, %d missed, %d late by up to %.1e, %d early by more than 1e-3\n", all.touching, all.missed,
              all.late, all.latest, all.far_early);
  return all;
}

class ContactsOfQueries : public testing::TestWithParam<Accuracy> {};

INSTANTIATE_TEST_SUITE_P(Accuracies, ContactsOfQueries,
                         testing::Values(Accuracy::fast, Accuracy::precise, Accuracy::conservative),
                         [](const auto& test) { return name_of(test.param); });

TEST_P(ContactsOfQueries, in_float_are_not_missed_and_never_late) {
  const Tally found = tally(GetParam(), /*is_single=*/true, 150);
  EXPECT_GT(found.touching, 500);
  EXPECT_EQ(found.missed, 0);
  EXPECT_EQ(found.late, 0) << "by up to " << found.latest;
}

TEST(Conservative, misses_nothing_and_is_never_late_for_positions_in_double) {
  const Tally found = tally(Accuracy::conservative, /*is_single=*/false, 300);
  EXPECT_GT(found.touching, 500);
  EXPECT_EQ(found.missed, 0);
  EXPECT_EQ(found.late, 0) << "by up to " << found.latest;
  EXPECT_LT(found.far_early, found.touching / 5);
}

double residual_of(float a, float b) {
  const float sum = a + b;
  return (static_cast<double>(a) + static_cast<double>(b)) - static_cast<double>(sum);
}

/// Returns a point above a triangle that lies below the plane z = 0, so that their distance is not a float.
Scene point_above(double height, double depth, float margin_a, float margin_b) {
  const Mesh floor{{{{0, 1, 2}}}, {{-8, -8, -depth}, {16, -8, -depth}, {-8, 16, -depth}}};
  const Mesh point{{{{0, 0, 0}}}, {{0.25, 0.5, height}}};
  Scene scene{still(floor, everything(margin_a)), still(point, everything(margin_b))};
  for (SceneBody& body : scene) body.settings.self_collision = false;
  return scene;
}

// The distance lies between the margins' sum and that sum rounded to float.
TEST(MarginsOfAPair, are_not_summed_to_less_than_they_are) {
  Random random(5);
  int built = 0;
  for (int attempt = 0; built < 300 && attempt < 5000; ++attempt) {
    const auto a = static_cast<float>(random.uniform(0.5, 2.0));
    const auto b = static_cast<float>(std::pow(10.0, -random.uniform(1.0, 6.0)));
    const double residual = residual_of(a, b);
    if (!(residual > 0.0)) continue;
    ++built;
    const auto depth = static_cast<double>(static_cast<float>(0.9 * residual));
    const Scene scene = point_above(static_cast<double>(a + b), depth, a, b);
    for (const ContactRule rule : {ContactRule::distance, ContactRule::slab}) {
      for (const Accuracy accuracy : {Accuracy::precise, Accuracy::conservative}) {
        PipelineOptions options = options_for(Detection::dcd, accuracy);
        options.contact_rule = rule;
        ASSERT_EQ(detect_once(scene, options).size(), 1U) << a << " + " << b;
      }
    }
    const Scene beyond = point_above(static_cast<double>(a + b) * (1 + 1e-6), depth, a, b);
    ASSERT_TRUE(detect_once(beyond, options_for(Detection::dcd, Accuracy::conservative)).empty()) << a << " + " << b;
  }
  EXPECT_EQ(built, 300);
}

// The margin grows by the length of a motion, which is not a float either.
TEST(MarginsOfAPair, do_not_lose_what_a_motion_adds) {
  Random random(6);
  for (int i = 0; i < 300; ++i) {
    const auto margin = static_cast<float>(random.uniform(0.1, 1.0));
    Scene scene = point_above(0.0, 0.0, margin, 0.0F);
    Vec3d move = random.in_box(1.0);
    move = {static_cast<double>(static_cast<float>(move.x)), static_cast<double>(static_cast<float>(move.y)), 0.0};
    const double reach = static_cast<double>(margin) + 2.0 * std::sqrt(squared_norm(move));
    auto height = static_cast<double>(static_cast<float>(reach));
    if (height > reach) height = static_cast<double>(std::nextafter(static_cast<float>(reach), 0.0F));
    const auto depth = static_cast<double>(static_cast<float>((reach - height) * 0.9));
    scene = point_above(height, depth, margin, 0.0F);
    scene[1].x_t0[0] = {0.25 + move.x, 0.5 + move.y, height};
    for (double* coordinate : {&scene[1].x_t0[0].x, &scene[1].x_t0[0].y}) {
      *coordinate = static_cast<double>(static_cast<float>(*coordinate));
    }
    const double exact =
        static_cast<double>(margin) + 2.0 * std::sqrt(squared_norm(scene[1].x_t1[0] - scene[1].x_t0[0]));
    if (!(exact * (1.0 - 1e-15) > height + depth)) continue;
    PipelineOptions options = options_for(Detection::dcd, Accuracy::conservative);
    options.motion_margin = 2.0F;
    ASSERT_EQ(detect_once(scene, options).size(), 1U) << "margin " << margin << ", move " << move.x << " " << move.y;
  }
}

/// A vertex's margin against another body's triangles grows with its motion, which rounding may have shortened. Margins
/// of edges do not grow.
TEST(MarginsOfAPair, grow_by_the_roundings_of_a_motion_for_vertices_of_other_bodies_alone) {
  Mesh cloth = grid_cloth(2, 2, 1.0);
  for (Vec3d& x : cloth.positions) x = x + Vec3d{1.0 / 3.0, 1.0 / 7.0, 1.0 / 9.0};
  Mesh other = cloth;
  for (Vec3d& x : other.positions) x.z += 0.01;
  PipelineOptions options = options_for(Detection::dcd, Accuracy::conservative);
  options.motion_margin = 1e6F;
  const Scene scene = {still(cloth, everything(0.001F)), still(other, everything(0.001F))};
  for (const Contact& contact : detect_once(scene, options)) {
    EXPECT_EQ(contact.kind, ContactKind::vertex_triangle);
    EXPECT_NE(contact.body_a, contact.body_b);
  }
}

/// Returns two soups whose coordinates are not floats, moved away from the origin.
Scene soups_in_double(std::uint64_t seed) {
  Scene scene;
  Random random(seed);
  for (std::uint64_t i = 0; i < 2; ++i) {
    SoupOptions options;
    options.triangle_count = 150;
    options.half_extent = 1.0;
    options.joined_share = 0.4;
    options.seed = 10 * seed + i;
    Mesh mesh = triangle_soup(options);
    for (Vec3d& x : mesh.positions) x = x + Vec3d{0.3, 1.7, -0.9} + random.in_box(1e-3);
    scene.push_back(moving(mesh, jittered(mesh.positions, 0.2, seed + i), everything(0.01F)));
  }
  return scene;
}

/// Makes pairs of a vertex and a triangle of different bodies, with a margin just above their exact distance.
TEST(Conservative, finds_what_is_within_the_margin_for_positions_in_double) {
  Random random(11);
  int found_by_precise = 0;
  constexpr int kCount = 400;
  for (std::size_t i = 0; i < kCount; ++i) {
    const ContactKind kind = kKinds[i % 2];
    Query query = make_query(random, kind, Family::random, /*is_single=*/false);
    std::copy_n(query.rows.begin(), 4, query.rows.begin() + 4);
    const double distance = std::sqrt(squared_distance(kind, std::span<const Vec3d, 4>(query.rows.data(), 4)));
    // Half of it is a float, so the sum of both sides is exact.
    const float margin = std::nextafter(static_cast<float>(distance), 10.0F);
    ASSERT_GE(static_cast<double>(margin), distance);
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      QueryDetector detector(kind, options_for(detection, Accuracy::conservative), margin);
      ASSERT_TRUE(detector.detect(query)) << to_string(query);
    }
    found_by_precise +=
        QueryDetector(kind, options_for(Detection::dcd, Accuracy::precise), margin).detect(query) ? 1 : 0;
  }
  EXPECT_LT(found_by_precise, kCount) << "the queries are no harder than positions in float";
}

TEST(Conservative, gives_floats_in_double_the_contacts_of_floats) {
  Scene scene = soups_in_double(3);
  for (SceneBody& body : scene) {
    for (Positions3* x : {&body.x_t0, &body.x_t1}) {
      for (Vec3d& p : *x) p = vec3_cast<double>(vec3_cast<float>(p));
    }
  }
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const PipelineOptions options = options_for(detection, Accuracy::conservative);
    const std::vector<Contact> in_double = detect_once(scene, options);
    ASSERT_GT(in_double.size(), 100U);
    LoadedScene loaded = load(scene, options);
    std::vector<std::vector<Vec3f>> floats;
    for (const SceneBody& body : scene) {
      for (const Positions3* x : {&body.x_t0, &body.x_t1}) {
        floats.emplace_back();
        for (const Vec3d& p : *x) floats.back().push_back(vec3_cast<float>(p));
      }
    }
    for (std::size_t b = 0; b < scene.size(); ++b) {
      loaded.pipeline.scene.set_positions(loaded.ids[b], floats[2 * b], floats[2 * b + 1]);
    }
    EXPECT_TRUE(identical(in_double, loaded.pipeline.detect()));
  }
}

// The detector keeps rounded positions from its earlier detections.
TEST(Conservative, answers_the_same_when_asked_again_or_after_another_accuracy) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const PipelineOptions options = options_for(detection, Accuracy::conservative);
    const std::vector<FeaturePair> expected = features_of(detect_once(soups_in_double(4), options));
    ASSERT_GT(expected.size(), 100U);
    LoadedScene loaded = load(soups_in_double(4), options_for(detection, Accuracy::precise));
    loaded.pipeline.detect();
    loaded.pipeline.set_options(options);
    EXPECT_EQ(features_of(loaded.pipeline.detect()), expected);
    EXPECT_EQ(features_of(loaded.pipeline.detect()), expected);
  }
}

TEST(UnsettledContacts, are_marked_and_counted) {
  std::uint64_t unsettled = 0;
  for (const ContactKind kind : kKinds) {
    for (const float margin : {0.0F, 1e-6F}) {
      QueryDetector detector(kind, options_for(Detection::ccd, Accuracy::conservative), margin);
      for (const Family family : {Family::tangential, Family::needle, Family::near_grazing}) {
        Random random(31);
        for (int i = 0; i < 500; ++i) {
          const std::optional<Contact> contact = detector.detect(make_query(random, kind, family, true));
          const std::uint64_t marked = contact && contact->is_unsettled ? 1 : 0;
          ASSERT_EQ(detector.statistics().unsettled_contacts, marked);
          unsettled += marked;
        }
      }
    }
  }
  std::printf("%d unsettled\n", static_cast<int>(unsettled));
  EXPECT_GT(unsettled, 0U);
}

TEST(UnsettledContacts, are_of_conservative_only) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    for (const Contact& contact : detect_once(soups_in_double(5), options_for(detection, Accuracy::precise))) {
      ASSERT_FALSE(contact.is_unsettled);
    }
  }
}

// Points whose distance from the triangle is 0, and not always as it is computed.
TEST(Conservative, finds_points_on_triangles) {
  Random random(17);
  int found_by_precise = 0;
  constexpr int kPoints = 300;
  const auto integer = [&random] { return static_cast<double>(random.below(2000)) - 1000.0; };
  QueryDetector conservative(ContactKind::vertex_triangle, options_for(Detection::dcd, Accuracy::conservative));
  QueryDetector precise(ContactKind::vertex_triangle, options_for(Detection::dcd, Accuracy::precise));
  for (int i = 0; i < kPoints; ++i) {
    Query query = make_query(random, ContactKind::vertex_triangle, Family::random, /*is_single=*/false);
    for (std::size_t corner = 1; corner < 4; ++corner) query.rows[corner] = {integer(), integer(), integer()};
    query.rows[0] = 0.25 * query.rows[1] + 0.25 * query.rows[2] + 0.5 * query.rows[3];
    std::copy_n(query.rows.begin(), 4, query.rows.begin() + 4);
    ASSERT_TRUE(conservative.detect(query)) << to_string(query);
    found_by_precise += precise.detect(query) ? 1 : 0;
  }
  EXPECT_LT(found_by_precise, kPoints) << "all are computed to be exactly on their triangles";
}

}  // namespace
}  // namespace softcd::test

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "expectations.hpp"
#include "ground_truth.hpp"
#include "mesh_generators.hpp"
#include "query_detector.hpp"
#include "recorded_queries.hpp"
#include "softcd/mesh/given_positions.hpp"

// Accuracy::conservative judges positions in double as given, however far they are from the detector's floats.
namespace softcd::test {
namespace {

PipelineOptions conservative(Detection detection) {
  PipelineOptions options = test_options(detection);
  options.accuracy = Accuracy::conservative;
  return options;
}

std::optional<TimeBracket> first_contact_of(const SceneGeometry& geometry, const FeaturePair& pair) {
  const std::array<Vec3d, 8> rows = geometry.motion(pair);
  return pair.kind == ContactKind::vertex_triangle ? first_contact_vertex_triangle(rows)
                                                   : first_contact_edge_edge(rows);
}

/// Returns the time of the first touch among `contacts`, none of which may be late.
double first_touch(const Scene& scene, std::vector<Contact> contacts) {
  std::sort(contacts.begin(), contacts.end(),
            [](const Contact& a, const Contact& b) { return a.time_of_impact < b.time_of_impact; });
  const SceneGeometry geometry(scene);
  double first = 1.0;
  for (const Contact& contact : contacts) {
    if (static_cast<double>(contact.time_of_impact) > first) break;
    const std::optional<TimeBracket> touch = first_contact_of(geometry, features_of(contact));
    if (touch) first = std::min(first, touch->lo);
  }
  return first;
}

class StepsInDouble : public testing::TestWithParam<const char*> {};

TEST_P(StepsInDouble, are_free_up_to_a_hundredth_before_the_first_touch) {
  const std::filesystem::path folder = data_folder("ccd-steps");
  const std::string step = std::string("ccd-steps/") + GetParam();
  if (data_folder(step).empty()) GTEST_SKIP() << missing_data(step);
  const GroundTruth truth = read_ground_truth(folder, GetParam());
  const Outcome outcome = outcome_of(truth.scene, conservative(Detection::ccd));
  const Difference difference = compare({truth.colliding(), {}}, features_of(outcome.contacts));
  EXPECT_TRUE(difference.missed.empty()) << describe(difference);
  const double exact = first_touch(truth.scene, outcome.contacts);
  std::cout << GetParam() << ": free up to " << outcome.statistics.earliest_toi << ", first touch at " << exact << '\n';
  EXPECT_LE(outcome.statistics.earliest_toi, exact);
  EXPECT_GE(outcome.statistics.earliest_toi, 0.99 * exact);
}

INSTANTIATE_TEST_SUITE_P(Recorded, StepsInDouble,
                         testing::Values("armadillo-rollers", "rod-twist", "cloth-funnel", "cloth-ball"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(QueriesInDouble, are_not_missed_not_late_and_seldom_reported_in_vain) {
  const std::filesystem::path folder = data_folder("ccd-queries");
  if (folder.empty()) GTEST_SKIP() << missing_data("ccd-queries");
  QueryDetector of_vertex(ContactKind::vertex_triangle, conservative(Detection::ccd));
  QueryDetector of_edges(ContactKind::edge_edge, conservative(Detection::ccd));
  std::size_t queries = 0;
  std::size_t missed = 0;
  std::size_t late = 0;
  std::size_t in_vain = 0;
  for (const RecordedQuery& recorded : read_recorded_queries(folder)) {
    const Query query = to_double(recorded);
    const std::optional<Contact> contact =
        (query.kind == ContactKind::vertex_triangle ? of_vertex : of_edges).detect(query);
    ++queries;
    if (!contact && !recorded.collides) continue;
    const std::optional<TimeBracket> touch = first_contact(query);
    missed += touch && !contact ? 1 : 0;
    in_vain += !touch && contact ? 1 : 0;
    late += touch && contact && static_cast<double>(contact->time_of_impact) > touch->hi ? 1 : 0;
  }
  std::cout << queries << " queries, " << in_vain << " reported that do not touch\n";
  EXPECT_EQ(missed, 0U);
  EXPECT_EQ(late, 0U);
  EXPECT_LE(in_vain, queries / 40);
}

/// A cloth of 1 m that sinks onto a ground of so many metres.
Scene cloth_above_ground(double width, double height, double sinks, float margin) {
  const double half = 0.5 * width;
  const Mesh ground = {{{{0, 1, 2}}, {{0, 2, 3}}},
                       {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}}};
  const Mesh cloth = moved(grid_cloth(11, 11, 0.1), {0.2931 * half, -0.1717 * half, height});
  Scene scene = {still(ground, everything()),
                 moving(cloth, translated(cloth.positions, {0, 0, -sinks}), everything(margin))};
  for (SceneBody& body : scene) body.settings.self_collision = false;
  return scene;
}

TEST(WideScenes, have_no_contacts_of_a_cloth_just_above_the_ground) {
  for (const double width : {700.0, 7e3, 7e4}) {
    const Scene scene = cloth_above_ground(width, 1e-4, 0.5e-4, 0.0F);
    EXPECT_TRUE(detect_once(scene, conservative(Detection::ccd)).empty()) << width << " m wide";
    EXPECT_TRUE(detect_once(scene, conservative(Detection::dcd)).empty()) << width << " m wide";
  }
}

TEST(WideScenes, have_contacts_within_margins_much_smaller_than_roundings) {
  for (const double width : {700.0, 7e3, 7e4}) {
    const Scene scene = cloth_above_ground(width, 1e-4, 0.0, 0.9e-4F);
    EXPECT_TRUE(detect_once(scene, conservative(Detection::dcd)).empty()) << width << " m wide";
    EXPECT_TRUE(detect_once(scene, conservative(Detection::ccd)).empty()) << width << " m wide";
    const Scene nearby = cloth_above_ground(width, 1e-4, 0.0, 1.1e-4F);
    EXPECT_GE(detect_once(nearby, conservative(Detection::dcd)).size(), 121U) << width << " m wide";
    EXPECT_GE(detect_once(nearby, conservative(Detection::ccd)).size(), 121U) << width << " m wide";
  }
}

TEST(WideScenes, tell_when_a_cloth_meets_the_ground) {
  for (const double width : {700.0, 7e3, 7e4}) {
    const Outcome outcome = outcome_of(cloth_above_ground(width, 1e-4, 4e-4, 0.0F), conservative(Detection::ccd));
    EXPECT_NEAR(outcome.statistics.earliest_toi, 0.25, 1e-5) << width << " m wide";
  }
}

/// A point and three directions at right angles.
struct Frame {
  Vec3d place, u, w, normal;
};

Frame random_frame(Random& random, double width) {
  const Vec3d place = {random.uniform(-0.5, 0.5) * width, random.uniform(-0.5, 0.5) * width,
                       random.uniform(-0.5, 0.5) * width};
  const Vec3d u = unit_vector(random.in_box(1.0));
  const Vec3d w = unit_vector(cross(u, random.in_box(1.0)));
  return {place, u, w, cross(u, w)};
}

/// Pairs of triangles of 5 cm, all over a plane, the upper ones a gap above the lower ones, all turned.
Scene pairs_of_triangles(double width, double gap, float margin) {
  Mesh mesh;
  Random random(77);
  for (std::uint32_t i = 0; i < 100; ++i) {
    const auto [place, u, w, normal] = random_frame(random, width);
    const Vec3d point = place + 0.01 * u + 0.01 * w + gap * normal;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.triangles.push_back({{first, first + 1, first + 2}});
    mesh.triangles.push_back({{first + 3, first + 3, first + 3}});
    for (const Vec3d& x : {place, place + 0.05 * u, place + 0.05 * w, point}) mesh.positions.push_back(x);
  }
  return {still(mesh, everything(margin))};
}

TEST(WideScenes, have_the_distances_and_normals_of_positions_as_given) {
  for (const double width : {100.0, 1e3, 1e4, 1e5}) {
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      constexpr double kGap = 1e-4;
      const Scene scene = pairs_of_triangles(width, kGap, 1e-4F);
      const std::vector<Contact> contacts = detect_once(scene, conservative(detection));
      ASSERT_EQ(contacts.size(), 100U);
      for (const Contact& contact : contacts) {
        const Positions3& x = scene[0].x_t1;
        Vec3d offset = x[contact.vertices[0]] - x[contact.vertices[1]];
        for (const int corner : {2, 3}) {
          offset = offset - static_cast<double>(contact.weights[corner]) *
                                (x[contact.vertices[corner]] - x[contact.vertices[1]]);
        }
        EXPECT_NEAR(contact.distance, kGap, 1e-6 * width * 0x1p-20 + 1e-10) << width << " m wide";
        EXPECT_GT(dot(vec3_cast<double>(contact.normal), offset), 0.999 * kGap) << width << " m wide";
      }
    }
  }
}

/// Pairs of triangles all over a space, the nearest edges of which cross at right angles, a gap apart, all turned.
Scene pairs_of_crossing_edges(double width, double gap, float margin) {
  Mesh mesh;
  Random random(78);
  for (std::uint32_t i = 0; i < 100; ++i) {
    const auto [place, u, w, normal] = random_frame(random, width);
    const Vec3d above = place + gap * normal;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const std::uint32_t corner : {0U, 3U}) {
      mesh.triangles.push_back({{first + corner, first + corner + 1, first + corner + 2}});
    }
    for (const Vec3d& x : {place - 0.02 * u, place + 0.03 * u, place - 0.05 * normal, above - 0.02 * w,
                           above + 0.03 * w, above + 0.05 * normal}) {
      mesh.positions.push_back(x);
    }
  }
  return {still(mesh, everything(margin))};
}

TEST(WideScenes, have_the_distances_and_normals_of_edges_as_given) {
  for (const double width : {100.0, 1e3, 1e4, 1e5}) {
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      constexpr double kGap = 1e-4;
      const Scene scene = pairs_of_crossing_edges(width, kGap, 1e-4F);
      const std::vector<Contact> contacts = detect_once(scene, conservative(detection));
      ASSERT_EQ(contacts.size(), 100U);
      for (const Contact& contact : contacts) {
        ASSERT_EQ(contact.kind, ContactKind::edge_edge);
        const Positions3& x = scene[0].x_t1;
        const auto point = [&](int end) {
          const Vec3d& start = x[contact.vertices[end]];
          return start + static_cast<double>(contact.weights[end + 1]) * (x[contact.vertices[end + 1]] - start);
        };
        EXPECT_NEAR(contact.distance, kGap, 1e-6 * width * 0x1p-20 + 1e-10) << width << " m wide";
        EXPECT_GT(dot(vec3_cast<double>(contact.normal), point(0) - point(2)), 0.999 * kGap) << width << " m wide";
      }
    }
  }
}

TEST(WideScenes, are_not_full_of_contacts_for_one_triangle_far_away) {
  SoupOptions options;
  options.triangle_count = 400;
  Mesh soup = triangle_soup(options);
  for (Vec3d& x : soup.positions) x = x + Vec3d{0.3, 1.7, -0.9};
  const auto contacts_of = [&](const Mesh& mesh, Detection detection) {
    const Positions3 end = jittered(mesh.positions, 0.1, 3);
    return features_of(detect_once({moving(mesh, end, everything(0.01F))}, conservative(detection)));
  };
  Mesh with_stray = soup;
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  with_stray.triangles.push_back({{first, first + 1, first + 2}});
  for (const Vec3d& x : {Vec3d{1e6, 1e6, 1e6}, Vec3d{1e6 + 1, 1e6, 1e6}, Vec3d{1e6, 1e6 + 1, 1e6}}) {
    with_stray.positions.push_back(x + Vec3d{0.1, 0.2, 0.3});
  }
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const std::vector<FeaturePair> expected = contacts_of(soup, detection);
    ASSERT_GT(expected.size(), 50U);
    EXPECT_EQ(contacts_of(with_stray, detection), expected);
  }
}

/// A margin that grows with a motion does not grow with the motion's rounding.
TEST(MotionMargins, are_those_of_the_motion_as_given) {
  for (const double height : {1.5, 3.0}) {
    const Mesh floor{{{{0, 1, 2}}}, {{-8e3, -8e3, 0}, {16e3, -8e3, 0}, {-8e3, 16e3, 0}}};
    const Mesh point{{{{0, 0, 0}}}, {{1000.1, 500.3, height}}};
    Scene scene{still(floor, everything()), still(point, everything())};
    scene[1].x_t0[0].z += 2e-6;
    PipelineOptions options = conservative(Detection::dcd);
    options.motion_margin = 1e6F;
    EXPECT_EQ(detect_once(scene, options).size(), height < 2.0 ? 1U : 0U) << height;
  }
}

/// Rounding may turn the planes of small triangles by any angle.
TEST(SlabRule, judges_positions_in_double_as_they_were_given) {
  const Vec3d place = {1000.1, -700.3, 300.7};
  for (const double height : {0.9e-5, 1.1e-5}) {
    const Mesh floor{{{{0, 1, 2}}}, {place, place + Vec3d{1e-3, 0, 0}, place + Vec3d{0, 1e-3, 0}}};
    const Mesh point{{{{0, 0, 0}}}, {place + Vec3d{2e-4, 3e-4, height}}};
    PipelineOptions options = conservative(Detection::dcd);
    options.contact_rule = ContactRule::slab;
    // Keeps the origin, relative to which positions are rounded, far away.
    const Mesh stray{{{{0, 0, 0}}}, {{-1000.1, 700.3, -300.7}}};
    const Scene scene{still(floor, everything(1e-5F)), still(point, everything()), still(stray, everything())};
    EXPECT_EQ(detect_once(scene, options).size(), height < 1e-5 ? 1U : 0U) << height;
  }
}

// Double keeps 1 alone of the difference, and 1 is a float.
TEST(RoundedPositions, are_told_where_the_origin_takes_what_is_small) {
  EXPECT_TRUE(is_rounded(1.0, 0x1p-60));
  EXPECT_TRUE(is_rounded(0x1p-60, 1.0));
  EXPECT_FALSE(is_rounded(1.0, 0.0));
  EXPECT_FALSE(is_rounded(0x1p-60, 0.0));
}

// The step ends at floats and begins between two floats. Rounding then changes the length of the motion only.
TEST(MotionMargins, are_those_of_the_motion_as_given_where_only_its_beginning_is_rounded) {
  for (const double height : {1.5, 3.0}) {
    const Mesh floor{{{{0, 1, 2}}}, {{-8192, -8192, 0}, {16384, -8192, 0}, {-8192, 16384, 0}}};
    const Mesh point{{{{0, 0, 0}}}, {{1000.0, 500.0, height}}};
    Scene scene{still(floor, everything()), still(point, everything())};
    scene[1].x_t0[0].z += 2e-8;
    PipelineOptions options = conservative(Detection::dcd);
    options.motion_margin = 1e8F;
    EXPECT_EQ(detect_once(scene, options).size(), height < 2.0 ? 1U : 0U) << height;
  }
}

/// On multiples of 2^-40, of which quarters are doubles, too.
Vec3d on_fine_grid(Vec3d p) {
  const auto round = [](double x) { return std::round(x * 0x1p+40) * 0x1p-40; };
  return {round(p.x), round(p.y), round(p.z)};
}

// Two triangles with a common vertex, of which a second one of the one lies on the other: as floats it is beside it.
TEST(WideScenes, have_contacts_of_neighbours_that_touch) {
  Random random(19);
  for (int i = 0; i < 50; ++i) {
    const Vec3d shared = on_fine_grid(Vec3d{700.1, -700.3, 300.7} + random.in_box(100.0));
    const Vec3d a = on_fine_grid(shared + random.direction());
    const Vec3d b = on_fine_grid(shared + random.direction());
    const Vec3d on_it = 0.25 * shared + 0.25 * a + 0.5 * b;
    const Vec3d beyond = on_it + random.direction();
    const Mesh fold{{{{0, 1, 2}}, {{0, 3, 4}}}, {shared, a, b, on_it, beyond}};
    // Keeps the origin, relative to which positions are rounded, far away.
    const Mesh stray{{{{0, 0, 0}}}, {{-1000.1, 1000.3, -1000.7}}};
    const std::vector<Contact> contacts =
        detect_once({still(fold, everything()), still(stray, everything())}, conservative(Detection::dcd));
    const auto is_expected = [](const Contact& contact) {
      return contact.kind == ContactKind::vertex_triangle && contact.feature_a == 3 && contact.feature_b == 0;
    };
    ASSERT_TRUE(std::any_of(contacts.begin(), contacts.end(), is_expected)) << i;
  }
}

}  // namespace
}  // namespace softcd::test

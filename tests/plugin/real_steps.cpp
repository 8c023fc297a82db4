#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "exact_ccd.hpp"
#include "expectations.hpp"
#include "ground_truth.hpp"
#include "rank_scene.hpp"

namespace softcd::test {
namespace {

class RealSteps : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::filesystem::path folder = data_folder("ccd-steps");
    if (folder.empty()) GTEST_SKIP() << missing_data("ccd-steps");
    truth_ = read_ground_truth(folder, GetParam());
  }

  GroundTruth truth_;
};

TEST_P(RealSteps, data_is_as_described) {
  const bool is_cloth = std::string(GetParam()) == "cloth-ball";
  EXPECT_EQ(truth_.scene[0].triangles.size(), is_cloth ? 92230U : 24242U);
  EXPECT_EQ(truth_.listed.size(), is_cloth ? 19034U + 94825U : 4652U + 19313U);
  EXPECT_EQ(truth_.colliding().size(), is_cloth ? 19032U + 94822U : 4650U + 19308U);
}

// The verdicts of the data hold for the coordinates as stored. The detector's are float32. Therefore coordinates of a
// double frame are rounded first and the listed pairs judged again; this changes nothing for float frames.
TEST_P(RealSteps, continuous_detection_misses_nothing) {
  const bool is_stored_in_float = std::string(GetParam()) == "cloth-ball";
  std::vector<FeaturePair> expected = truth_.colliding();
  if (!is_stored_in_float) {
    round_to_float(truth_.scene);
    expected.clear();
    const SceneGeometry geometry(truth_.scene);
    for (const FeaturePair& pair : truth_.listed) {
      const std::array<Vec3d, 8> rows = geometry.motion(pair);
      const bool hit =
          pair.kind == ContactKind::vertex_triangle ? collides_vertex_triangle(rows) : collides_edge_edge(rows);
      if (hit) expected.push_back(pair);
    }
    std::sort(expected.begin(), expected.end());
  }
  const std::vector<Contact> contacts = detect_once(truth_.scene, test_options(Detection::ccd));
  const Difference difference = compare({expected, {}}, features_of(contacts));
  EXPECT_TRUE(difference.missed.empty()) << describe(difference);
  EXPECT_TRUE(difference.repeated.empty()) << describe(difference);
  expect_sorted(contacts);
  std::cout << GetParam() << ": " << expected.size() << " colliding, " << contacts.size() << " reported, "
            << difference.extra.size() << " of them not colliding exactly\n";
  const SceneGeometry geometry(truth_.scene);
  const double touching = 1e-6 * half_extent_of(truth_.scene);
  for (const FeaturePair& pair : difference.extra) {
    const auto contact = std::lower_bound(contacts.begin(), contacts.end(), pair,
                                          [](const Contact& c, const FeaturePair& p) { return features_of(c) < p; });
    EXPECT_LE(geometry.distance_near(pair, contact->time_of_impact), touching) << pair;
  }
}

TEST_P(RealSteps, several_ranks_find_what_one_finds) {
  const PipelineOptions options = test_options(Detection::ccd);
  const std::vector<Contact> expected = detect_once(truth_.scene, options);
  for (const int rank_count : {2, 3, 5, 8}) {
    expect_no_problem(in_ranks(Communicator::of_threads(rank_count), [&](const Communicator& communicator) {
      RankScene rank(truth_.scene, communicator, options);
      rank.set_positions(truth_.scene);
      rank.query().detect();
      EXPECT_TRUE(identical(expected, rank.query().gather_contacts())) << communicator.rank() << " of " << rank_count;
    }));
  }
}

// For the coordinates as stored, in double or float, nothing is missed and no time is late.
TEST_P(RealSteps, conservative_misses_nothing_of_the_frames_as_stored) {
  PipelineOptions options = test_options(Detection::ccd);
  options.accuracy = Accuracy::conservative;
  const std::vector<Contact> contacts = detect_once(truth_.scene, options);
  const Difference difference = compare({truth_.colliding(), {}}, features_of(contacts));
  EXPECT_TRUE(difference.missed.empty()) << describe(difference);
  EXPECT_LE(difference.extra.size(), contacts.size() / 20);
  const SceneGeometry geometry(truth_.scene);
  std::size_t late = 0;
  // Exact times take long, so only a few thousand are checked.
  for (std::size_t i = 0; i < contacts.size(); i += 1 + contacts.size() / 4096) {
    const Contact& contact = contacts[i];
    const std::array<Vec3d, 8> rows = geometry.motion(features_of(contact));
    const std::optional<TimeBracket> truth = contact.kind == ContactKind::vertex_triangle
                                                 ? first_contact_vertex_triangle(rows)
                                                 : first_contact_edge_edge(rows);
    late += truth && static_cast<double>(contact.time_of_impact) > truth->hi ? 1 : 0;
  }
  EXPECT_EQ(late, 0U);
  std::cout << GetParam() << ": " << contacts.size() << " reported, " << difference.extra.size()
            << " of them not colliding exactly\n";
}

TEST_P(RealSteps, other_ways_give_the_same_bytes) {
  const std::vector<Contact> expected = detect_once(truth_.scene, test_options(Detection::ccd));
  PipelineOptions options = test_options(Detection::ccd);
  options.subdivision = false;
  EXPECT_TRUE(identical(expected, detect_once(truth_.scene, options))) << "without subdivision";
  options.subdivision = true;
  options.cell_size_factor = 1.2F;
  EXPECT_TRUE(identical(expected, detect_once(truth_.scene, options))) << "cell_size_factor 1.2";
}

TEST_P(RealSteps, discrete_detection_at_a_tenth_of_the_mean_edge) {
  Scene scene = truth_.scene;
  round_to_float(scene);
  const double margin = 0.1 * mean_edge_length({scene[0].triangles, scene[0].x_t1});
  scene[0].settings.margin = static_cast<float>(0.5 * margin);
  DiscreteRules rules;
  rules.absolute_band = 4.0 * 0x1p-24 * half_extent_of(scene);
  const std::size_t count = expect_discrete_contacts(scene, test_options(Detection::dcd), rules);
  EXPECT_GT(count, 1000U);
  std::cout << GetParam() << ": " << count << " contacts within " << margin << '\n';
}

INSTANTIATE_TEST_SUITE_P(Steps, RealSteps, testing::Values("cloth-ball", "armadillo-rollers"),
                         [](const auto& test) { return test.index == 0 ? "cloth_ball" : "armadillo_rollers"; });

}  // namespace
}  // namespace softcd::test

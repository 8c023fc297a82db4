#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kNative = "Bullet";
constexpr const char* kOurs = "softcd world, cpu";
constexpr const char* kFloor = "floor";

class BenchBullet : public testing::Test {
 protected:
  using Variants = std::map<std::string, nlohmann::json>;

  /// Expects what holds for every scene, and that nothing fell through the support at the height `support`.
  Variants measure(const std::string& arguments, double support) {
    const Result result =
        run_program(SOFTCD_BENCH, "bullet --steps 4 " + arguments + " --json " + folder_.file("json"), folder_);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(result.errors, IsEmpty());
    Variants variants;
    const nlohmann::json measured = nlohmann::json::parse(folder_.read("json"));
    for (const auto& variant : measured.at("variants")) {
      EXPECT_GT(variant["first_step_ms"], 0) << variant;
      EXPECT_GT(variant["median_step_ms"], 0) << variant;
      EXPECT_GT(variant["lowest_node"], support - kSunkAtMost) << variant;
      variants[variant["name"]] = variant;
    }
    EXPECT_FALSE(variants.at(kFloor).contains("median_our_ms"));
    const nlohmann::json& ours = variants.at(kOurs);
    EXPECT_LT(ours["median_our_ms"], ours["median_step_ms"]) << ours;
    EXPECT_TRUE(ours.contains("median_answer_ms")) << ours;
    EXPECT_EQ(variants.at(kFloor)["median_soft_contacts"], 0);
    EXPECT_EQ(variants.at(kFloor)["median_rigid_contacts"], variants.at(kOurs)["median_rigid_contacts"])
        << "the floor steps from the same state";
    return variants;
  }

  static constexpr double kSunkAtMost = 0.05;  ///< into static bodies

  TemporaryFolder folder_;
};

TEST_F(BenchBullet, a_cloth_drapes_over_rigid_balls) {
  for (const char* world : {"soft", "deformable"}) {
    for (const auto& [name, variant] : measure("--scene draped --size 16 --world " + std::string(world), 0)) {
      EXPECT_GT(variant["median_rigid_contacts"], 20) << variant;
      EXPECT_LT(variant["median_soft_contacts"], 100) << "one cloth, hardly folded " << variant;
      EXPECT_NEAR(variant["highest_node"], 0.7, 0.05) << "it lies on the balls " << variant;
    }
  }
}

TEST_F(BenchBullet, a_cloth_that_crumples_collides_with_itself) {
  const Variants classic = measure("--scene crumpling --size 24", 0);
  EXPECT_EQ(classic.at(kNative)["median_soft_contacts"], 0);
  EXPECT_THAT(folder_.read("output"), HasSubstr("Bullet's own detection finds no contacts within a body"));
  EXPECT_GT(classic.at(kOurs)["median_soft_contacts"], 100);
  EXPECT_GT(classic.at("softcd dispatcher, cpu")["median_soft_contacts"], 100);

  const Variants deformable = measure("--scene crumpling --size 24 --world deformable", 0);
  EXPECT_GT(deformable.at(kNative)["median_soft_contacts"], 100);
  EXPECT_GT(deformable.at(kOurs)["median_soft_contacts"], 100);
}

TEST_F(BenchBullet, cloths_that_touch_themselves_lie_on_each_other) {
  const Variants classic = measure("--scene stacked --size 12", 0);
  const Variants deformable = measure("--scene stacked --size 12 --world deformable", 0);
  for (const Variants& variants : {classic, deformable}) {
    for (const char* name : {kNative, kOurs}) {
      EXPECT_GT(variants.at(name)["median_soft_contacts"], 100) << variants.at(name);
      EXPECT_LT(variants.at(name)["highest_node"], 0.15) << variants.at(name);
    }
  }
}

// A falling body must be braked before it is within both margins, or it bounces.
TEST_F(BenchBullet, stacked_cloths_do_not_hop_after_a_second) {
  const Variants classic = measure("--scene stacked --size 12 --warm-up 60", 0);
  const double bullets = classic.at(kNative)["highest_node"].get<double>();
  EXPECT_LT(classic.at(kOurs)["highest_node"].get<double>(), bullets + 0.01);
}

TEST_F(BenchBullet, balls_drop_onto_each_other) {
  for (const char* world : {"soft --warm-up 25", "deformable --warm-up 50"}) {
    const Variants variants = measure("--scene balls --size 8 --world " + std::string(world), 0);
    for (const char* name : {kNative, kOurs}) {
      EXPECT_GT(variants.at(name)["median_soft_contacts"], 20) << variants.at(name);
      EXPECT_GT(variants.at(name)["median_rigid_contacts"], 20) << variants.at(name);
      EXPECT_GT(variants.at(name)["highest_node"], 1.5) << "two layers " << variants.at(name);
    }
  }
}

TEST_F(BenchBullet, a_cloth_falls_onto_another) {
  for (const char* world : {"soft", "deformable"}) {
    const Variants variants = measure("--scene two-cloths --size 16 --world " + std::string(world), 0);
    EXPECT_GT(variants.at(kNative)["median_soft_contacts"], 20);
    EXPECT_GT(variants.at(kOurs)["median_soft_contacts"], 20);
  }
}

TEST_F(BenchBullet, large_bodies_are_left_to_ours_and_that_is_said) {
  const Variants variants = measure("--scene draped --size 16 --warm-up 1 --most-native-faces 449", 0);
  EXPECT_EQ(variants.count(kNative), 0u);
  EXPECT_THAT(folder_.read("output"), HasSubstr("Bullet's own detection is left out: a body has more than 449 faces"));
  EXPECT_EQ(measure("--scene draped --size 16 --warm-up 1 --most-native-faces 450", 0).count(kNative), 1u);
}

TEST_F(BenchBullet, markdown_is_what_is_printed) {
  measure("--size 8 --warm-up 1 --markdown " + folder_.file("tables.md"), 0);
  EXPECT_EQ(folder_.read("tables.md"), "### Bullet: " + folder_.read("output") + "\n");
  EXPECT_THAT(folder_.read("output"), HasSubstr("\n| softcd dispatcher, cpu |"));
}

TEST_F(BenchBullet, refuses_command_lines) {
  const auto expect_refused = [this](const std::string& arguments, const std::string& problem) {
    test::expect_refused(SOFTCD_BENCH, "bullet " + arguments, folder_, problem);
  };
  expect_refused("--scene rope", "'rope' is not one of two-cloths, balls, draped, crumpling, stacked");
  expect_refused("--world rigid", "'rigid' is not one of soft, deformable");
  expect_refused("--size 7", "--size");
  expect_refused("--most-native-faces -1", "--most-native-faces");
}

}  // namespace
}  // namespace softcd::test

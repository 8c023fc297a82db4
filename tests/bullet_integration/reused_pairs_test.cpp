// Steps are the same with kept pairs and with a new search in each detection.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.hpp"
#include "small_scenes.hpp"

namespace softcd::test {
namespace {

constexpr int kReusingSteps = 40;

std::unique_ptr<demo::Scene> make(const std::string& name, demo::World world, Detection detection, bool reuse_pairs) {
  demo::SceneOptions options;
  options.world = world;
  options.settings = careful_settings(detection);
  options.settings.reuse_pairs = reuse_pairs;
  options.size = name == "n-body" ? 8 : std::max(16, demo::find_scene(name)->smallest_size);
  return demo::make_scene(name, options);
}

std::vector<btScalar> coordinates_of(demo::Scene& scene) {
  std::vector<btScalar> coordinates;
  for (const btSoftBody* body : scene.simulation().bodies()) append(coordinates, test::coordinates_of(*body));
  return coordinates;
}

std::size_t contacts_of(const Statistics& statistics) {
  return statistics.vt_contacts + statistics.ee_contacts;
}

TEST(ReusedPairs, leave_every_step_of_a_classic_world_as_it_is) {
  for (const char* const name : {"cloth-on-ball", "two-cloths", "stack", "n-body"}) {
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      SCOPED_TRACE(name);
      const auto scene = make(name, demo::World::classic, detection, /*reuse_pairs=*/true);
      const auto other = make(name, demo::World::classic, detection, /*reuse_pairs=*/false);
      int reused = 0;
      for (int step = 0; step < kReusingSteps; ++step) {
        scene->step();
        other->step();
        ASSERT_EQ(coordinates_of(*scene), coordinates_of(*other)) << "after step " << step;
        reused += scene->simulation().detection()->crossing_report().statistics().reused_pairs ? 1 : 0;
      }
      EXPECT_EQ(reused > 0, detection == Detection::ccd);
    }
  }
}

/// Bullet's deformable world does not repeat itself, so that each step starts from the same positions.
TEST(ReusedPairs, find_as_much_in_every_step_of_a_deformable_world) {
  for (const char* const name : {"cloth-on-ball", "two-cloths"}) {
    SCOPED_TRACE(name);
    const auto scene = make(name, demo::World::deformable, Detection::ccd, /*reuse_pairs=*/true);
    const auto other = make(name, demo::World::deformable, Detection::ccd, /*reuse_pairs=*/false);
    int reused = 0;
    std::size_t contacts = 0;
    scene->step();
    for (int step = 0; step < kReusingSteps; ++step) {
      other->go_on_from(*scene);
      scene->simulation().step();
      other->simulation().step();
      const bullet::WorldDetection& detection = *scene->simulation().detection();
      const bullet::WorldDetection& anew = *other->simulation().detection();
      ASSERT_EQ(contacts_of(detection.contact_report().statistics()), contacts_of(anew.contact_report().statistics()));
      contacts += contacts_of(detection.contact_report().statistics());
      reused += detection.crossing_report().statistics().reused_pairs ? 1 : 0;
      reused += detection.contact_report().statistics().reused_pairs ? 1 : 0;
    }
    EXPECT_GT(contacts, 0U);
    EXPECT_GT(reused, kReusingSteps / 2);
  }
}

}  // namespace
}  // namespace softcd::test

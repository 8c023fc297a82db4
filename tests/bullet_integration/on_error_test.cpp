// Steps in which softcd fails.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <stdexcept>

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "failing_allocations.hpp"
#include "layers.hpp"

namespace softcd::test {
namespace {

using bullet::OnError;
using bullet::WorldDetection;

class FailingSteps : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, FailingSteps, kWorlds, world_name);

/// Lets each allocation of the second step fail in turn: what that leaves to Bullet is as in Bullet's own world.
TEST_P(FailingSteps, have_bullets_contacts_where_memory_runs_out) {
  const bullet::Settings settings = cpu_settings(is_deformable(GetParam()) ? Detection::ccd : Detection::dcd);
  const auto make = [&] { return std::make_unique<Layers>(GetParam(), settings); };
  const auto ours = make();
  Layers bullets(GetParam(), std::nullopt);
  for (int i = 0; i < 2; ++i) {
    ours->step();
    bullets.step();
  }
  const LayerContacts expected = ours->contacts();
  const LayerContacts bullets_own = bullets.contacts();
  ASSERT_FALSE(expected.soft.empty() || expected.rigid.empty());
  ASSERT_FALSE(bullets_own.soft.empty() || bullets_own.rigid.empty());
  std::uint64_t failed_contacts = 0;
  std::uint64_t failed_meshes = 0;
  for_every_allocation([&](std::uint64_t n) {
    SCOPED_TRACE("allocation " + std::to_string(n));
    const auto layers = make();
    const WorldDetection& detection = layers->detection();
    layers->step();
    bool has_failed = false;
    {
      const FailingAllocation failing(n);
      EXPECT_NO_THROW(layers->step());
      has_failed = failing.has_failed();
    }
    const std::uint64_t contacts = detection.contact_report().failed_steps();
    const std::uint64_t meshes = detection.rigid_mesh_report().failed_steps();
    EXPECT_LE(contacts + meshes, 1U);
    EXPECT_EQ(layers->contacts().soft, contacts > 0 ? bullets_own.soft : expected.soft);
    EXPECT_EQ(layers->contacts().rigid, meshes > 0 ? bullets_own.rigid : expected.rigid);
    layers->step();
    EXPECT_EQ(layers->contacts().soft, expected.soft);
    EXPECT_EQ(layers->contacts().rigid, expected.rigid);
    EXPECT_EQ(detection.contact_report().failed_steps() + detection.rigid_mesh_report().failed_steps(),
              contacts + meshes);
    failed_contacts += contacts;
    failed_meshes += meshes;
    return has_failed && !testing::Test::HasFailure();
  });
  std::cout << failed_contacts << " failures of contacts, " << failed_meshes << " of rigid meshes\n";
  EXPECT_GT(failed_contacts, 0U);
  EXPECT_GT(failed_meshes, 0U);
}

/// Returns the same contacts as body_contacts() reports them for the last step.
LayerContacts told_contacts(Layers& layers) {
  LayerContacts told;
  for (const bullet::BodyPairContacts& pair : layers.simulation().detection().body_contacts()) {
    for (const bullet::BodyContact& contact : pair.contacts) {
      const bool has_node_on_a = contact.a.feature == bullet::ContactSide::Feature::node;
      const bullet::ContactSide& node = has_node_on_a ? contact.a : contact.b;
      const btCollisionObject* owner = has_node_on_a ? pair.a : pair.b;
      if (contact.b.feature == bullet::ContactSide::Feature::object) {
        told.rigid.insert({layers.index_of(owner), node.nodes[0]});
      } else {
        told.soft.insert({layers.index_of(owner), node.nodes[0], has_node_on_a ? contact.b.face : contact.a.face});
      }
    }
  }
  return told;
}

/// Expects that all contacts of a step are reported, softcd's and Bullet's, or none if memory runs out.
template <class Make>
void expect_all_contacts_or_none_to_be_told(const Make& make) {
  std::uint64_t untold = 0;
  std::uint64_t fallen_back = 0;
  for_every_allocation([&](std::uint64_t n) {
    SCOPED_TRACE("allocation " + std::to_string(n));
    const auto layers = make();
    layers->step();
    bool has_failed = false;
    {
      const FailingAllocation failing(n);
      EXPECT_NO_THROW(layers->step());
      has_failed = failing.has_failed();
    }
    const LayerContacts told = told_contacts(*layers);
    if (told.soft.empty() && told.rigid.empty()) {
      ++untold;
    } else {
      EXPECT_EQ(told.soft, layers->contacts().soft);
      EXPECT_EQ(told.rigid, layers->contacts().rigid);
      fallen_back +=
          layers->detection().contact_report().failed_steps() + layers->detection().rigid_mesh_report().failed_steps();
    }
    layers->step();
    EXPECT_EQ(told_contacts(*layers).soft, layers->contacts().soft);
    EXPECT_EQ(told_contacts(*layers).rigid, layers->contacts().rigid);
    return has_failed && !testing::Test::HasFailure();
  });
  EXPECT_GT(untold, 0U);
  EXPECT_GT(fallen_back, 0U) << "Bullet's own contacts are told, too";
}

TEST(OnError, contacts_are_told_where_there_is_memory) {
  bullet::Settings settings = cpu_settings();
  settings.read_out = bullet::ReadOut::impulses;
  for (const World world : {World::one_line, World::deformable}) {
    SCOPED_TRACE(name_of(world));
    expect_all_contacts_or_none_to_be_told([&] { return std::make_unique<Layers>(world, settings); });
  }
}

TEST(OnError, a_step_without_memory_for_the_look_at_crossings_goes_without_it) {
  const btScalar velocity = -30;
  bullet::Settings settings = cpu_settings(Detection::ccd);
  settings.rigid_meshes = false;  // whose contacts a world of softcd's solves once more, a dispatcher does not
  const auto motions_with = [&](World world) {
    Layers layers(world, settings);
    layers.answer_nothing();
    layers.step();
    layers.step(velocity);
    return layers.motions();
  };
  const auto with_look = motions_with(World::one_line);
  const auto without_look = motions_with(World::dispatcher);
  ASSERT_NE(with_look, without_look);
  std::uint64_t failed = 0;
  for_every_allocation([&](std::uint64_t n) {
    SCOPED_TRACE("allocation " + std::to_string(n));
    Layers layers(World::one_line, settings);
    layers.answer_nothing();
    layers.step();
    bool has_failed = false;
    {
      const FailingAllocation failing(n);
      EXPECT_NO_THROW(layers.step(velocity));
      has_failed = failing.has_failed();
    }
    const WorldDetection& detection = layers.detection();
    if (detection.contact_report().failed_steps() + detection.rigid_mesh_report().failed_steps() == 0) {
      EXPECT_EQ(layers.motions(), detection.crossing_report().failed_steps() > 0 ? without_look : with_look);
    }
    failed += detection.crossing_report().failed_steps();
    return has_failed && !testing::Test::HasFailure();
  });
  std::cout << failed << " failures\n";
  EXPECT_GT(failed, 0U);
}

/// Settings whose log throws at the first warning, which is that of a node whose position is no number.
bullet::Settings settings_that_fail(std::vector<std::string>& said) {
  bullet::Settings settings = cpu_settings();
  settings.log = [&said](LogLevel, std::string_view text) {
    said.emplace_back(text);
    if (text.find("finite") != std::string_view::npos) throw Error("from the log");
  };
  return settings;
}

TEST(OnError, is_said_once_and_counted) {
  std::vector<std::string> said;
  Layers layers(World::one_line, settings_that_fail(said));
  layers.spoil();
  for (int i = 0; i < 3; ++i) EXPECT_NO_THROW(layers.step());
  EXPECT_EQ(layers.detection().contact_report().failed_steps(), 3U);
  EXPECT_EQ(layers.detection().contact_report().backend(), Backend::cpu);
  EXPECT_TRUE(layers.detection().contact_report().explain().empty());
  const auto tells =
      testing::AllOf(testing::HasSubstr("contacts between soft bodies"), testing::HasSubstr("from the log"));
  EXPECT_EQ(std::count_if(said.begin(), said.end(), [&](const auto& text) { return testing::Matches(tells)(text); }),
            1);
}

TEST(OnError, may_be_thrown) {
  std::vector<std::string> said;
  bullet::Settings settings = settings_that_fail(said);
  settings.on_error = OnError::throw_error;
  Layers layers(World::one_line, settings);
  layers.spoil();
  EXPECT_THROW(layers.step(), Error);
  EXPECT_EQ(layers.detection().contact_report().failed_steps(), 1U);
}

TEST(OnError, what_an_app_throws_passes) {
  for (const World world : kEveryWorld) {
    SCOPED_TRACE(name_of(world));
    Layers layers(world, cpu_settings());
    layers.step();
    const LayerContacts expected = layers.contacts();
    layers.simulation().dispatcher().setNearCallback(
        [](btBroadphasePair&, btCollisionDispatcher&, const btDispatcherInfo&) {
          throw std::domain_error("the app's");
        });
    EXPECT_THROW(layers.step(), std::domain_error);
    layers.simulation().dispatcher().setNearCallback(btCollisionDispatcher::defaultNearCallback);
    layers.step();
    EXPECT_EQ(layers.contacts().soft, expected.soft);
    EXPECT_EQ(layers.contacts().rigid, expected.rigid);
    EXPECT_EQ(layers.detection().contact_report().failed_steps(), 0U);
  }
}

}  // namespace
}  // namespace softcd::test

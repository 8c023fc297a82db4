// Callbacks of apps add and remove bodies while a step runs. Bullet's solvers keep pointers to bodies until the step is
// over; after it bodies may be deleted.

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <tuple>

#include "any_simulation.hpp"
#include "interruption.hpp"

namespace softcd::test {
namespace {

/// Two sheets that touch each other and one far away.
class ComingAndGoing : public testing::TestWithParam<std::tuple<World, When>> {
 protected:
  ComingAndGoing() : simulation(std::get<World>(GetParam()), settings()) {
    held = &add(0, true);
    falling = &add(btScalar(0.12));
    loner = &add(0);
    loner->translate(btVector3(20, 0, 0));
    EXPECT_TRUE(comes_to_touch(*falling));
  }

  static bullet::Settings settings() {
    bullet::Settings settings = careful_settings();
    settings.read_out = bullet::ReadOut::impulses;
    return settings;
  }
  btSoftBody& add(btScalar height, bool fixed = false) {
    SheetOptions options;
    options.height = height;
    options.fixed = fixed;
    return simulation.add(make_sheet(simulation.world_info(), options));
  }
  /// Within a second.
  bool comes_to_touch(const btSoftBody& body) {
    for (int i = 0; i < 60; ++i) {
      simulation.step();
      if (touches(body)) return true;
    }
    return false;
  }
  void interrupt(const std::function<void()>& f) {
    const Interruption interruption(simulation.world(), std::get<When>(GetParam()), f);
    simulation.step();
    gone.reset();
  }
  bool touches(const btSoftBody& body) {
    bool does = false;
    for (const bullet::BodyPairContacts& pair : simulation.detection().body_contacts()) {
      does |= !pair.contacts.empty() && (pair.a == &body || pair.b == &body);
    }
    return does;
  }

  AnySimulation simulation;
  std::unique_ptr<btSoftBody> gone;  ///< removed in the step that runs
  btSoftBody* held = nullptr;
  btSoftBody* falling = nullptr;
  btSoftBody* loner = nullptr;
};
INSTANTIATE_TEST_SUITE_P(Worlds, ComingAndGoing,
                         testing::Combine(kWorlds,
                                          testing::Values(When::before_tick, When::in_action, When::after_tick)),
                         [](const auto& parameter) {
                           return name_of(std::get<World>(parameter.param)) + "_" +
                                  name_of(std::get<When>(parameter.param));
                         });

TEST_P(ComingAndGoing, a_body_that_touches_nobody_may_go) {
  interrupt([&] { gone = simulation.remove(*loner); });
  EXPECT_TRUE(comes_to_touch(*falling));
}

TEST_P(ComingAndGoing, a_body_that_touches_others_may_go) {
  interrupt([&] { gone = simulation.remove(*falling); });
  EXPECT_FALSE(comes_to_touch(*held));
}

TEST_P(ComingAndGoing, bodies_may_come) {
  btSoftBody* late = nullptr;
  interrupt([&] { late = &add(btScalar(0.2)); });
  EXPECT_TRUE(comes_to_touch(*late));
  EXPECT_TRUE(comes_to_touch(*held));
}

TEST_P(ComingAndGoing, one_may_take_the_place_of_another) {
  btSoftBody* late = nullptr;
  interrupt([&] {
    gone = simulation.remove(*falling);
    late = &add(btScalar(0.12));
  });
  EXPECT_TRUE(comes_to_touch(*late));
}

}  // namespace
}  // namespace softcd::test

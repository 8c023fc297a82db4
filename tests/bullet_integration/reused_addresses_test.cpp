// An app deletes bodies and makes others, as between two episodes of training. A new body may get the address of one
// that has gone, and must not inherit anything from it.

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <vector>

#include "any_simulation.hpp"

namespace softcd::test {
namespace {

/// Deletes a body and makes one with the same nodes, links and faces as `model` at its address.
std::unique_ptr<btSoftBody> remake(std::unique_ptr<btSoftBody> gone, btSoftBody& model) {
  std::vector<btVector3> x;
  std::vector<btScalar> masses;
  for (int i = 0; i < model.m_nodes.size(); ++i) {
    x.push_back(model.m_nodes[i].m_x);
    masses.push_back(model.m_nodes[i].m_im > 0 ? 1 / model.m_nodes[i].m_im : 0);
  }
  btSoftBody* const address = gone.release();
  address->~btSoftBody();
  std::unique_ptr<btSoftBody> made(new (static_cast<void*>(address))
                                       btSoftBody(model.getWorldInfo(), int(x.size()), x.data(), masses.data()));
  const auto number = [&](const btSoftBody::Node* node) { return int(node - &model.m_nodes[0]); };
  for (int i = 0; i < model.m_links.size(); ++i) {
    made->appendLink(number(model.m_links[i].m_n[0]), number(model.m_links[i].m_n[1]));
  }
  for (int i = 0; i < model.m_faces.size(); ++i) {
    const auto& n = model.m_faces[i].m_n;
    made->appendFace(number(n[0]), number(n[1]), number(n[2]));
  }
  made->m_cfg = model.m_cfg;
  made->getCollisionShape()->setMargin(model.getCollisionShape()->getMargin());
  return made;
}

class ReusedAddress : public testing::TestWithParam<World> {
 protected:
  explicit ReusedAddress(const bullet::Settings& settings = careful_settings()) : simulation(GetParam(), settings) {
    simulation.set_gravity(btVector3(0, -10, 0));
  }
  std::unique_ptr<btSoftBody> sheet(btScalar height, bool fixed = false) {
    SheetOptions options;
    options.height = height;
    options.fixed = fixed;
    return make_sheet(simulation.world_info(), options);
  }
  AnySimulation simulation;
};

using ReusedAddressInClassicWorlds = ReusedAddress;
INSTANTIATE_TEST_SUITE_P(Worlds, ReusedAddressInClassicWorlds, kClassicWorlds, world_name);

/// Bullet's solver takes contacts one after the other, so another order would lead to other positions.
TEST_P(ReusedAddressInClassicWorlds, leads_to_the_same_motion) {
  const auto fall = [&](std::unique_ptr<btSoftBody> upper) {
    const btSoftBody& lower = simulation.add(sheet(0, /*fixed=*/true));
    const btSoftBody& falling = simulation.add(std::move(upper));
    bool has_touched = false;
    for (int i = 0; i < 20; ++i) {
      simulation.step();
      has_touched |= !simulation.detection().edge_contacts().empty();
    }
    EXPECT_TRUE(has_touched);
    std::vector<btVector3> x;
    for (int i = 0; i < falling.m_nodes.size(); ++i) x.push_back(falling.m_nodes[i].m_x);
    simulation.remove(const_cast<btSoftBody&>(lower));
    auto removed = simulation.remove(const_cast<btSoftBody&>(falling));
    return std::pair(std::move(x), std::move(removed));
  };
  const auto tilted = [&] {
    auto body = sheet(btScalar(0.2));
    body->rotate(btQuaternion(btVector3(1, 0, 1).normalized(), btScalar(0.3)));
    return body;
  };
  auto [x, gone] = fall(tilted());
  const auto [x_again, unused] = fall(remake(std::move(gone), *tilted()));
  ASSERT_EQ(x.size(), x_again.size());
  EXPECT_EQ(std::memcmp(x.data(), x_again.data(), x.size() * sizeof(btVector3)), 0);
}

/// Energies and momenta are sums over bodies. The order of the bodies in memory must not decide their rounding.
TEST_P(ReusedAddressInClassicWorlds, leads_to_the_same_sums) {
  constexpr int kCount = 8;
  const auto fall = [](bool from_the_top) {
    AnySimulation falling(GetParam(), careful_settings());
    std::vector<std::unique_ptr<btSoftBody>> sheets(kCount);
    for (int i = 0; i < kCount; ++i) {
      const int place = from_the_top ? kCount - 1 - i : i;
      SheetOptions options;
      options.height = btScalar(0.2) * btScalar(place);
      sheets[std::size_t(place)] = make_sheet(falling.world_info(), options);
      sheets[std::size_t(place)]->setVelocity(btVector3(0, btScalar(-7.3) * btScalar(place), btScalar(0.1)));
    }
    for (auto& sheet : sheets) falling.add(std::move(sheet));
    std::vector<bullet::CrossingAnswers> answers;
    for (int i = 0; i < 6; ++i) {
      falling.step();
      answers.push_back(falling.detection().crossing_answers());
    }
    return answers;
  };
  const auto from_the_bottom = fall(false);
  const auto from_the_top = fall(true);
  std::uint64_t impacts = 0;
  for (std::size_t i = 0; i < from_the_bottom.size(); ++i) {
    impacts += from_the_bottom[i].impacts;
    EXPECT_EQ(from_the_bottom[i].impacts, from_the_top[i].impacts);
    EXPECT_EQ(from_the_bottom[i].energy, from_the_top[i].energy);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(from_the_bottom[i].momentum[axis], from_the_top[i].momentum[axis]);
    }
  }
  EXPECT_TRUE(impacts > 100 || GetParam() == World::dispatcher);  // which prevents no crossings
}

INSTANTIATE_TEST_SUITE_P(Worlds, ReusedAddress, kWorldsOfRun, world_name);

TEST_P(ReusedAddress, has_no_filters_of_the_body_before) {
  simulation.add(sheet(0, /*fixed=*/true));
  btSoftBody& first = simulation.add(sheet(btScalar(0.09)));
  bullet::BodyFilters filters;
  filters.nodes.assign(std::size_t(first.m_nodes.size()), {1, 0});  // keeps them from everything
  simulation.detection().set_filters(first, filters);
  simulation.step();
  EXPECT_EQ(simulation.detection().contact_report().statistics().vt_contacts, 0U);

  simulation.add(remake(simulation.remove(first), *sheet(btScalar(0.09))));
  simulation.step();
  EXPECT_GT(simulation.detection().contact_report().statistics().vt_contacts, 0U);
}

}  // namespace
}  // namespace softcd::test

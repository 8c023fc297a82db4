// Meshes that change while others touch them: a cloth that a ball tears, and one that is refined where it folds. No
// step ends with an edge through a triangle, in exact arithmetic.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "any_simulation.hpp"
#include "scenes/penetration.hpp"

namespace softcd::test {
namespace {

/// Cuts some of the links that are stretched by a third, and are not short. Returns how many.
int tear(btSoftBody& cloth) {
  int cuts = 0;
  for (int l = 0; l < cloth.m_links.size() && cuts < 6; ++l) {
    const btSoftBody::Link& link = cloth.m_links[l];
    const btScalar length = (link.m_n[1]->m_x - link.m_n[0]->m_x).length();
    if (link.m_rl < btScalar(0.03) || length < btScalar(1.3) * link.m_rl) continue;
    const auto first = static_cast<int>(link.m_n[0] - &cloth.m_nodes[0]);
    const auto second = static_cast<int>(link.m_n[1] - &cloth.m_nodes[0]);
    if (!cloth.cutLink(first, second, btScalar(0.5))) continue;
    for (int added = 1; added <= 2; ++added) cloth.setMass(cloth.m_nodes.size() - added, btScalar(0.003));
    ++cuts;
  }
  return cuts;
}

TEST(Tearing, a_ball_passes_through_a_cloth_only_where_it_is_torn) {
  demo::Simulation simulation(demo::PlugIn::one_line_world, careful_settings());
  SheetOptions options;
  options.nodes_per_side = 13;
  options.margin = btScalar(0.02);
  std::unique_ptr<btSoftBody> sheet = make_sheet(simulation.world_info(), options);
  for (const int corner : {0, 12, 156, 168}) sheet->setMass(corner, 0);
  btSoftBody& cloth = simulation.add(std::move(sheet));
  std::unique_ptr<btSoftBody> round(btSoftBodyHelpers::CreateEllipsoid(
      simulation.world_info(), btVector3(0, btScalar(0.25), 0), btVector3(1, 1, 1) * btScalar(0.18), 120));
  round->setTotalMass(4);
  round->setPose(/*bvolume=*/false, /*bframe=*/true);
  round->m_cfg.kMT = btScalar(0.2);
  round->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  round->getCollisionShape()->setMargin(btScalar(0.02));
  round->setVelocity(btVector3(0, -4, 0));
  btSoftBody& ball = simulation.add(std::move(round));

  const auto is_between = [](const btSoftBody& edges, const btSoftBody& triangles) { return &edges != &triangles; };
  int cuts = 0;
  std::size_t contacts = 0;
  for (int step = 0; step < 40; ++step) {
    cuts += tear(cloth);
    simulation.step(kStep);
    contacts += simulation.detection()->contact_report().statistics().vt_contacts;
    ASSERT_EQ(demo::find_intersections({&cloth, &ball}, is_between).edge_count, 0U) << "after step " << step;
  }
  EXPECT_GT(cuts, 10);
  EXPECT_GT(contacts, 100U);
}

/// The plane at which the cloth is to have nodes.
class Plane : public btSoftBody::ImplicitFn {
 public:
  explicit Plane(btScalar x) : x_(x) {}
  btScalar Eval(const btVector3& at) override { return at.x() - x_; }

 private:
  btScalar x_;
};

// Laid over a ridge, held on one side, it folds along the ridge, and touches itself below.
TEST(Tearing, a_cloth_that_is_refined_where_it_folds_is_never_through_itself) {
  demo::Simulation simulation(demo::PlugIn::one_line_world, careful_settings());
  SheetOptions options;
  options.nodes_per_side = 9;
  options.margin = btScalar(0.02);
  std::unique_ptr<btSoftBody> sheet = make_sheet(simulation.world_info(), options);
  btSoftBody& cloth = simulation.add(std::move(sheet));
  cloth.setSelfCollision(true);
  for (int n = 0; n < cloth.m_nodes.size(); ++n) {
    if (btFabs(cloth.m_nodes[n].m_x.x()) < btScalar(0.1)) cloth.setMass(n, 0);
  }
  const int faces = cloth.m_faces.size();
  std::size_t contacts = 0;
  for (int step = 0; step < 80; ++step) {
    if (step % 20 == 10) {
      const int refinement = step / 20;
      Plane plane(btScalar(0.02) * btScalar(refinement - 2) + btScalar(0.011));
      cloth.refine(&plane, btScalar(0.001), /*cut=*/false);
    }
    for (int n = 0; n < cloth.m_nodes.size(); ++n) {  // the sides swing together
      btSoftBody::Node& node = cloth.m_nodes[n];
      if (node.m_im > 0) node.m_v.setX(node.m_v.x() - (node.m_x.x() > 0 ? kStep : -kStep) * btScalar(4));
    }
    simulation.step(kStep);
    contacts += simulation.detection()->contact_report().statistics().vt_contacts;
    ASSERT_EQ(demo::find_intersections({&cloth}).edge_count, 0U) << "after step " << step;
  }
  EXPECT_GT(cloth.m_faces.size(), faces + 20);
  EXPECT_GT(contacts, 100U);
}

}  // namespace
}  // namespace softcd::test

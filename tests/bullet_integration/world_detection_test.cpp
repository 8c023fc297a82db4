// The reports on softcd's part in a world.

#include <gtest/gtest.h>

#include "layers.hpp"

namespace softcd::test {
namespace {

using bullet::DetectorReport;
using bullet::WorldDetection;

void expect_nothing_done(const DetectorReport& report) {
  EXPECT_EQ(report.statistics().triangles, 0U);
  EXPECT_EQ(report.statistics().vt_contacts, 0U);
  EXPECT_EQ(report.backend(), Backend::cpu);
}

class Reports : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, Reports, kWorlds, world_name);

TEST_P(Reports, are_of_contacts_crossings_and_rigid_meshes) {
  Layers layers(GetParam(), cpu_settings(Detection::ccd));
  const WorldDetection& detection = layers.detection();
  for (const DetectorReport& report :
       {detection.contact_report(), detection.crossing_report(), detection.rigid_mesh_report()}) {
    expect_nothing_done(report);
  }
  EXPECT_TRUE(detection.edge_contacts().empty());
  layers.step();
  EXPECT_GT(detection.contact_report().statistics().vt_contacts, 0U);
  EXPECT_FALSE(detection.contact_report().explain().empty());
  EXPECT_EQ(detection.rigid_mesh_report().statistics().bodies, 3U)
      << "two sheets and a mesh, in one scene for all queries";
  EXPECT_GT(detection.rigid_mesh_report().statistics().vt_contacts, 0U);
  EXPECT_EQ(detection.crossing_report().statistics().bodies, GetParam() != World::dispatcher ? 4U : 0U)
      << "these, and the mesh on its way";
}

/// Two sheets that touch, and from when on they ask for contacts.
void expect_to_look_once_asked(World world, int flag) {
  AnySimulation simulation(world, cpu_settings(Detection::ccd));
  SheetOptions options;
  options.margin = btScalar(0.02);
  btSoftBody* sheets[2];
  for (int i = 0; i < 2; ++i) {
    options.height = btScalar(0.03) * btScalar(i);
    sheets[i] = &simulation.add(make_sheet(simulation.world_info(), options));
    sheets[i]->m_cfg.collisions &= ~(btSoftBody::fCollision::VF_SS | btSoftBody::fCollision::VF_DD);
  }
  const WorldDetection& detection = simulation.detection();
  simulation.step(kStep);
  for (const DetectorReport& report : {detection.contact_report(), detection.crossing_report()}) {
    expect_nothing_done(report);
    EXPECT_EQ(report.statistics().ms.total, 0.0) << "nothing asks for contacts, so that nothing is looked for";
  }
  for (btSoftBody* sheet : sheets) sheet->m_cfg.collisions |= flag;
  simulation.step(kStep);
  EXPECT_EQ(detection.contact_report().statistics().bodies, 2U);
  EXPECT_GT(detection.contact_report().statistics().vt_contacts, 0U);
  EXPECT_EQ(detection.crossing_report().statistics().bodies, 2U);
  for (btSoftBody* sheet : sheets) sheet->m_cfg.collisions &= ~flag;
  for (int step = 0; step < 2; ++step) simulation.step(kStep);
  for (const DetectorReport& report : {detection.contact_report(), detection.crossing_report()})
    expect_nothing_done(report);
}

TEST(WorldDetection, looks_for_nothing_where_nothing_asks_for_contacts) {
  expect_to_look_once_asked(World::one_line, btSoftBody::fCollision::VF_SS);
  expect_to_look_once_asked(World::deformable, btSoftBody::fCollision::VF_DD);
}

}  // namespace
}  // namespace softcd::test

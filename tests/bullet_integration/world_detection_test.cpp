// What an app can ask a world about softcd's part in it.

#include <gtest/gtest.h>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "deformable_support.hpp"

namespace softcd::test {
namespace {

using bullet::DetectorReport;
using bullet::WorldDetection;
using demo::DeformableSimulation;
using demo::PlugIn;
using demo::Simulation;

/// Two sheets that touch, the lower one lying on a rigid mesh of one large triangle.
template <class AnySimulation>
class Layers {
 public:
  explicit Layers(AnySimulation& simulation) {
    triangles_.addTriangle(btVector3(-3, 0, -3), btVector3(0, 0, 6), btVector3(3, 0, -3));
    simulation.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&triangles_, true), btVector3(0, 0, 0));
    SheetOptions options;
    options.margin = btScalar(0.02);
    for (const btScalar height : {btScalar(0.02), btScalar(0.05)}) {
      options.height = height;
      simulation.add(make_sheet(simulation.world_info(), options));
    }
  }

 private:
  btTriangleMesh triangles_;
};

void expect_nothing_done(const DetectorReport& report) {
  EXPECT_EQ(report.statistics().triangles, 0U);
  EXPECT_EQ(report.statistics().vt_contacts, 0U);
  EXPECT_EQ(report.backend(), Backend::cpu);
}

template <class AnySimulation>
void expect_reports(AnySimulation& simulation, bool prevents_crossings) {
  const Layers<AnySimulation> layers(simulation);
  const WorldDetection& detection = *simulation.detection();
  for (const DetectorReport& report :
       {detection.contact_report(), detection.crossing_report(), detection.rigid_mesh_report()}) {
    expect_nothing_done(report);
  }
  EXPECT_TRUE(detection.edge_contacts().empty());
  simulation.step(kStep);
  EXPECT_GT(detection.contact_report().statistics().vt_contacts, 0U);
  EXPECT_FALSE(detection.contact_report().explain().empty());
  EXPECT_EQ(detection.rigid_mesh_report().statistics().bodies, 3U)
      << "two sheets and a mesh, in one scene for all queries";
  EXPECT_GT(detection.rigid_mesh_report().statistics().vt_contacts, 0U);
  EXPECT_EQ(detection.crossing_report().statistics().bodies, prevents_crossings ? 4U : 0U)
      << "these, and the mesh on its way";
}

TEST(WorldDetection, reports_contacts_crossings_and_rigid_meshes_of_classic_worlds) {
  for (const PlugIn plug_in : kPlugIns) {
    SCOPED_TRACE(name_of(plug_in));
    Simulation simulation(plug_in, cpu_settings(Detection::ccd));
    expect_reports(simulation, plug_in != PlugIn::dispatcher);
  }
}

TEST(WorldDetection, reports_contacts_crossings_and_rigid_meshes_of_the_deformable_world) {
  DeformableSimulation simulation(cpu_settings(Detection::ccd));
  expect_reports(simulation, true);
}

/// Two sheets that touch, and from when on they ask for contacts.
template <class AnySimulation>
void expect_to_look_once_asked(AnySimulation& simulation, int flag) {
  SheetOptions options;
  options.margin = btScalar(0.02);
  btSoftBody* sheets[2];
  for (int i = 0; i < 2; ++i) {
    options.height = btScalar(0.03) * btScalar(i);
    sheets[i] = &simulation.add(make_sheet(simulation.world_info(), options));
    sheets[i]->m_cfg.collisions &= ~(btSoftBody::fCollision::VF_SS | btSoftBody::fCollision::VF_DD);
  }
  const WorldDetection& detection = *simulation.detection();
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
  Simulation classic(PlugIn::one_line_world, cpu_settings(Detection::ccd));
  expect_to_look_once_asked(classic, btSoftBody::fCollision::VF_SS);
  DeformableSimulation deformable(cpu_settings(Detection::ccd));
  expect_to_look_once_asked(deformable, btSoftBody::fCollision::VF_DD);
}

}  // namespace
}  // namespace softcd::test

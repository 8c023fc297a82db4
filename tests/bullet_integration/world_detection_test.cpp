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
  for (const DetectorReport& report : {detection.contacts(), detection.crossings(), detection.rigid_meshes()}) {
    expect_nothing_done(report);
  }
  EXPECT_TRUE(detection.edge_contacts().empty());
  simulation.step(kStep);
  EXPECT_GT(detection.contacts().statistics().vt_contacts, 0U);
  EXPECT_FALSE(detection.contacts().explain().empty());
  EXPECT_EQ(detection.rigid_meshes().statistics().bodies, 3U) << "two sheets and a mesh, in one scene for all queries";
  EXPECT_GT(detection.rigid_meshes().statistics().vt_contacts, 0U);
  EXPECT_EQ(detection.crossings().statistics().bodies, prevents_crossings ? 4U : 0U)
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

}  // namespace
}  // namespace softcd::test

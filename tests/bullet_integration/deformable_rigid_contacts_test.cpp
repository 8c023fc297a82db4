// Rigid bodies on held cloths in the deformable world: softcd's worlds hold the bodies that Bullet alone holds.

#include <gtest/gtest.h>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "deformable_app_support.hpp"
#include "softcd/bullet/attach.hpp"

namespace softcd::test {
namespace {

enum class Detector { bullet, softcd, attached };

/// A cloth held at its edges, at a height of 0, and the body on it.
class Trampoline {
 public:
  Trampoline(Detector detector, int nodes_per_side, btScalar stiffness, Detection detection = Detection::dcd)
      : simulation_(detector == Detector::softcd ? MaybeSettings(cpu_settings(detection)) : std::nullopt,
                    {.elastic = stiffness}) {
    if (detector == Detector::attached) attachment_ = bullet::attach(simulation_.world(), cpu_settings(detection));
    demo::ClothShape shape = demo::horizontal_cloth(nodes_per_side, 4, 0);
    const int last = nodes_per_side - 1;
    shape.is_fixed = [last](int column, int row) { return column == 0 || row == 0 || column == last || row == last; };
    auto cloth = demo::make_cloth(simulation_.world_info(), shape, 5);
    cloth->getCollisionShape()->setMargin(kMargin);
    cloth_ = &simulation_.add(std::move(cloth));
  }

  btSoftBody& cloth() { return *cloth_; }
  btSoftBody& add_ball(const btVector3& center) {
    auto ball = make_soft_ball(simulation_.world_info(), center, btScalar(0.4));
    ball->getCollisionShape()->setMargin(kMargin);
    return simulation_.add(std::move(ball));
  }
  btRigidBody& add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center, btScalar mass) {
    btRigidBody& rigid = simulation_.add_rigid(std::move(shape), center, mass);
    rigid.setActivationState(DISABLE_DEACTIVATION);
    return rigid;
  }
  void step(int count) {
    for (int i = 0; i < count; ++i) simulation_.step(kShortStep);
  }
  const btAlignedObjectArray<btSoftBody*>& bodies() { return simulation_.world().getSoftBodyArray(); }

 private:
  static constexpr btScalar kMargin = btScalar(0.05);

  demo::DeformableSimulation simulation_;
  std::optional<bullet::Attachment> attachment_;
  btSoftBody* cloth_ = nullptr;
};

class DeformableRigidContacts : public testing::TestWithParam<Detector> {};
INSTANTIATE_TEST_SUITE_P(Worlds, DeformableRigidContacts, testing::Values(Detector::softcd, Detector::attached),
                         [](const auto& parameter) {
                           return std::string(parameter.param == Detector::softcd ? "one_line" : "attached");
                         });

/// Bullet's solver depends on the order of its contacts, which is that of its trees.
TEST_P(DeformableRigidContacts, move_a_cloth_bit_by_bit_as_in_bullet_alone) {
  for (const int flag : {0, int(btSoftBody::fCollision::SDF_RDF)}) {
    Trampoline ours(GetParam(), 15, 100);
    Trampoline bullets(Detector::bullet, 15, 100);
    for (Trampoline* each : {&ours, &bullets}) {
      each->cloth().m_cfg.collisions |= flag;
      each->add_rigid(std::make_unique<btSphereShape>(btScalar(0.5)), btVector3(btScalar(0.1), btScalar(0.6), 0), 8);
      each->add_rigid(std::make_unique<btBoxShape>(btVector3(1, 1, 1) / 4), btVector3(-1, btScalar(0.4), -1), 2);
    }
    int node_contacts = 0;
    int face_contacts = 0;
    for (int step = 0; step < 140; ++step) {
      ours.step(1);
      bullets.step(1);
      node_contacts += ours.cloth().m_nodeRigidContacts.size();
      face_contacts += ours.cloth().m_faceRigidContacts.size();
    }
    EXPECT_GT(node_contacts, 10);
    EXPECT_EQ(face_contacts > 0, flag != 0);
    for (int n = 0; n < ours.cloth().m_nodes.size(); ++n) {
      ASSERT_EQ(ours.cloth().m_nodes[n].m_x, bullets.cloth().m_nodes[n].m_x) << "node " << n;
      ASSERT_EQ(ours.cloth().m_nodes[n].m_v, bullets.cloth().m_nodes[n].m_v) << "node " << n;
    }
  }
}

/// Until the first contact of the ball nothing differs. ContactRule::slab alone reaches it a step before.
TEST_P(DeformableRigidContacts, leave_a_soft_ball_beside_them_bullets_contacts) {
  Trampoline ours(GetParam(), 21, 60);
  Trampoline bullets(Detector::bullet, 21, 60);
  for (Trampoline* each : {&ours, &bullets}) {
    each->add_ball(btVector3(btScalar(1.2), btScalar(0.6), 0));
    each->add_rigid(std::make_unique<btSphereShape>(btScalar(0.5)), btVector3(0, btScalar(0.6), 0), 8);
  }
  NodeFaceSet of_bullet;
  for (int step = 0; step < 100 && of_bullet.empty(); ++step) {
    ours.step(1);
    bullets.step(1);
    of_bullet = contacts_in(bullets.bodies());
    ASSERT_EQ(contacts_in(ours.bodies()), of_bullet) << "step " << step;
  }
  EXPECT_FALSE(of_bullet.empty());
}

}  // namespace
}  // namespace softcd::test

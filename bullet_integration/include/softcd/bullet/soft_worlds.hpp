#pragma once

#include <memory>
#include <vector>

#include "BulletSoftBody/btSoftMultiBodyDynamicsWorld.h"
#include "BulletSoftBody/btSoftRigidDynamicsWorld.h"
#include "softcd/bullet/edge_contact.hpp"
#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

class SoftWorldHooks;

/// btSoftRigidDynamicsWorld with vertex-face contacts between soft bodies (VF_SS) and within them found by softcd.
/// The app changes the line that creates its world; dispatcher and broad phase are whatever it had, except that a
/// softcd::bullet::Dispatcher keeps its own settings.
///
/// With Settings::detection ccd the way of all nodes through a step is looked at once more at its end, and changed
/// where a node would pass through a face.
///
/// Bullet's face trees are neither built nor refitted, and a body's node tree is refitted only in steps in which
/// the body's box overlaps a rigid one's; debug drawings of these trees show the last state that was needed.
class SoftRigidDynamicsWorld : public btSoftRigidDynamicsWorld {
 public:
  SoftRigidDynamicsWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase, btConstraintSolver* solver,
                         btCollisionConfiguration* configuration, btSoftBodySolver* soft_body_solver = nullptr,
                         const Settings& settings = {});
  ~SoftRigidDynamicsWorld() override;

  void performDiscreteCollisionDetection() override;

  const Settings& settings() const;
  /// From the next step on.
  void set_settings(const Settings& settings);
  /// statistics(), explain() and backend() of the detector.
  const CollisionPipeline& pipeline() const;
  /// Of the last step; empty unless Settings::edge_contacts asks for them.
  const std::vector<EdgeContact>& edge_contacts() const;

 protected:
  void predictUnconstraintMotion(btScalar time_step) override;
  void internalSingleStepSimulation(btScalar time_step) override;

 private:
  std::unique_ptr<SoftWorldHooks> hooks_;
};

/// The same for btSoftMultiBodyDynamicsWorld.
class SoftMultiBodyDynamicsWorld : public btSoftMultiBodyDynamicsWorld {
 public:
  SoftMultiBodyDynamicsWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                             btMultiBodyConstraintSolver* solver, btCollisionConfiguration* configuration,
                             btSoftBodySolver* soft_body_solver = nullptr, const Settings& settings = {});
  ~SoftMultiBodyDynamicsWorld() override;

  void performDiscreteCollisionDetection() override;

  const Settings& settings() const;
  void set_settings(const Settings& settings);
  const CollisionPipeline& pipeline() const;
  const std::vector<EdgeContact>& edge_contacts() const;

 protected:
  void predictUnconstraintMotion(btScalar time_step) override;
  void internalSingleStepSimulation(btScalar time_step) override;

 private:
  std::unique_ptr<SoftWorldHooks> hooks_;
};

}  // namespace softcd::bullet

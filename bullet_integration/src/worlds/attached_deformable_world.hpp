#pragma once

#include <vector>

#include "BulletDynamics/Dynamics/btActionInterface.h"
#include "BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h"
#include "worlds/attached_world.hpp"

namespace softcd::bullet {

/// An attached btDeformableMultiBodyDynamicsWorld. Contacts between soft bodies depend on the nodes' positions at the
/// start of the step. They are written before Bullet's solver runs, which does not change them. Bullet's own detection
/// then finds no face trees. The rest of softcd's step runs in an action, after Bullet has moved the nodes.
class AttachedDeformableWorld final : public AttachedWorld, private btActionInterface {
 public:
  AttachedDeformableWorld(btDeformableMultiBodyDynamicsWorld& world, const Settings& settings);

  Span<const Limitation> limitations() const override;

 private:
  /// A body's node positions before and after Bullet has moved them.
  struct Way {
    btSoftBody* body;
    std::vector<btVector3> starts, ends;
    std::vector<bool> are_placed;  ///< whether something has put the node elsewhere after Bullet has moved it
  };
  class NodesPutBack;

  /// The number of a body's contacts with soft bodies, which Bullet does not see after softcd has responded to them.
  struct HiddenContacts {
    btSoftBody* body;
    int count;
  };

  DeformableStep step() const { return AttachedWorld::step<DeformableStep>(); }
  void process(const Processing& process_natively) override { step().process(process_natively); }
  void process_late() override { step().process_late(); }
  void prepare_solver() override;
  void end_step(btScalar time_step) override;
  bool ends_steps_late() const override { return false; }
  void remove_hooks() override;
  void before_ray_test() override { face_trees().give_back(); }
  void after_ray_test() noexcept override;

  void updateAction(btCollisionWorld* world, btScalar time_step) override;
  void debugDraw(btIDebugDraw* /*drawer*/) override {}

  static void call_solver_callback(btScalar time, btDeformableMultiBodyDynamicsWorld* world);
  void after_solver();
  void show_soft_contacts();
  void keep_starts();
  void prevent_crossings(btScalar time_step);

  SolverCallback solver_callback_;
  int solver_calls_ = 0;        ///< of the callback in this step
  bool has_responded_ = false;  ///< whether softcd has responded to contacts between soft bodies in this step
  std::vector<HiddenContacts> hidden_;
  std::vector<Way> ways_;        ///< of the bodies that the step's last pass may change
  bool has_integrated_ = false;  ///< whether the step that ends has moved all bodies
};

}  // namespace softcd::bullet

#include "softcd/bullet/deformable_world.hpp"

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletSoftBody/btDeformableBodySolver.h"
#include "native/at_end.hpp"
#include "worlds/step_driver.hpp"

namespace softcd::bullet {

DeformableWorld::DeformableWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                                 btDeformableMultiBodyConstraintSolver* solver, btCollisionConfiguration* configuration,
                                 btDeformableBodySolver* deformable_solver, const Settings& settings)
    : btDeformableMultiBodyDynamicsWorld(dispatcher, broadphase, solver, configuration, deformable_solver),
      deformable_solver_(deformable_solver),
      detection_(kDeformableWorld, settings) {
  detection_.queries_->broadphase = [this] { return getBroadphase(); };
}

DeformableWorld::~DeformableWorld() {
  for (btSoftBody* body : span_of(getSoftBodyArray())) give_face_tree(*body);
}

void DeformableWorld::performDiscreteCollisionDetection() {
  btDeformableMultiBodyDynamicsWorld::performDiscreteCollisionDetection();
  detection_.queries_->forget_algorithms();
}

void DeformableWorld::rayTest(const btVector3& from, const btVector3& to, RayResultCallback& callback) const {
  detection_.queries_->rays.test(*m_broadphasePairCache, span_of(getSoftBodyArray()), from, to, callback,
                                 [this](auto&&... of_object) { rayTestSingle(of_object...); });
}

// Follows Bullet's internalSingleStepSimulation.
void DeformableWorld::internalSingleStepSimulation(btScalar time_step) {
  const DeformableStep step(*this, getSoftBodyArray(), *detection_.queries_);
  step.queries.rays.begin_motion();
  const AtEnd motion_ends([&step] {
    step.queries.massless_paths.end_paths(step.bodies());  // of a step that an exception leaves
    step.queries.rays.end_motion();
  });
  step.begin();
  if (m_internalPreTickCallback != nullptr) m_internalPreTickCallback(this, time_step);
  reinitialize(time_step);
  applyRigidBodyGravity(time_step);
  {
    const NodeTreesAtRest at_rest = step.predict();
    predictUnconstraintMotion(time_step);
  }
  updateAabbs();
  step.pairs();
  computeOverlappingPairs();
  step.process(
      [this] { getDispatcher()->dispatchAllCollisionPairs(getPairCache(), getDispatchInfo(), getDispatcher()); });
  calculateSimulationIslands();
  beforeSolverCallbacks(time_step);
  step.before_solver();
  solveConstraints(time_step);
  afterSolverCallbacks(time_step);

  step.find_soft_contacts();
  step.respond(time_step);

  // Bullet's integrateTransforms(). Anchors follow their rigid objects and take their nodes along.
  positionCorrection(time_step);
  // NOLINTNEXTLINE(bugprone-parent-virtual-call): the class in between would do the other two as well
  btMultiBodyDynamicsWorld::integrateTransforms(time_step);
  step.prevent_crossings(time_step);
  deformable_solver_->applyTransforms(time_step);
  step.place_ends();

  refit_face_trees(step.bodies());
  updateActions(time_step);
  updateActivationState(time_step);
  step.end();
}

}  // namespace softcd::bullet

#include "softcd/bullet/deformable_world.hpp"

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "BulletSoftBody/btDeformableBodySolver.h"
#include "worlds/world_step.hpp"

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

void DeformableWorld::predict(btScalar time_step) {
  const NodeTreesAtRest at_rest(span_of(getSoftBodyArray()), kDeformableTreeFlag);
  predictUnconstraintMotion(time_step);
}

void DeformableWorld::detect_rigid_contacts() {
  const WorldStep step{*this, getSoftBodyArray(), *detection_.queries_};
  updateAabbs();
  prepare_pairs(step);
  computeOverlappingPairs();
  process_deformable_pairs(
      step, [this] { getDispatcher()->dispatchAllCollisionPairs(getPairCache(), getDispatchInfo(), getDispatcher()); });
}

// Follows Bullet's internalSingleStepSimulation.
void DeformableWorld::internalSingleStepSimulation(btScalar time_step) {
  const WorldStep step{*this, getSoftBodyArray(), *detection_.queries_};
  WorldQueries& queries = step.queries;
  const NodesInMotion in_motion(queries.rays);
  queries.read_out.begin_step();
  if (m_internalPreTickCallback != nullptr) m_internalPreTickCallback(this, time_step);
  reinitialize(time_step);
  applyRigidBodyGravity(time_step);
  predict(time_step);
  detect_rigid_contacts();
  calculateSimulationIslands();
  beforeSolverCallbacks(time_step);
  queries.read_out.keep_velocities(step.body_span());
  solveConstraints(time_step);
  afterSolverCallbacks(time_step);

  find_soft_contacts(step);
  if (!queries.read_out.apply_repulsion(step.body_span(), time_step)) applyRepulsionForce(time_step);

  // Bullet's integrateTransforms(). Anchors follow their rigid objects and take their nodes along.
  positionCorrection(time_step);
  // NOLINTNEXTLINE(bugprone-parent-virtual-call): the class in between would do the other two as well
  btMultiBodyDynamicsWorld::integrateTransforms(time_step);
  queries.prevent_crossings(step.body_span(), getCollisionObjectArray(), step.gate(), time_step);
  deformable_solver_->applyTransforms(time_step);

  refit_face_trees(step.body_span());
  updateActions(time_step);
  updateActivationState(time_step);
  queries.read_out.finish(*getBroadphase());
}

}  // namespace softcd::bullet

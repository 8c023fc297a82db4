#include "softcd/bullet/deformable_world.hpp"

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "native_trees.hpp"
#include "world_queries.hpp"

namespace softcd::bullet {

DeformableWorld::DeformableWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                                 btDeformableMultiBodyConstraintSolver* solver, btCollisionConfiguration* configuration,
                                 btDeformableBodySolver* deformable_solver, const Settings& settings)
    : btDeformableMultiBodyDynamicsWorld(dispatcher, broadphase, solver, configuration, deformable_solver),
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

void DeformableWorld::predict(btScalar time_step) {
  const TreesOutOfSight out_of_sight(getSoftBodyArray(), &btSoftBody::m_ndbvt);
  const FaceTreesUnbuilt unbuilt(getSoftBodyArray());
  predictUnconstraintMotion(time_step);
}

void DeformableWorld::detect_rigid_contacts(const PairGate& gate) {
  updateAabbs();
  if (detection_.settings().rigid_meshes) {
    for (btSoftBody* body : span_of(getSoftBodyArray())) sweep_box(*body, *getBroadphase(), getDispatcher());
  }
  computeOverlappingPairs();
  for_each_near_rigid(*getPairCache(), refit_deformable_trees);
  detection_.queries_->begin_step(span_of(getSoftBodyArray()));
  detection_.queries_->process_rigid_pairs(gate, [this] {
    // Clusters go on.
    const VertexFaceTestsOff off(getSoftBodyArray());
    getDispatcher()->dispatchAllCollisionPairs(getPairCache(), getDispatchInfo(), getDispatcher());
  });
}

// The steps of Bullet's internalSingleStepSimulation.
void DeformableWorld::internalSingleStepSimulation(btScalar time_step) {
  WorldQueries& queries = *detection_.queries_;
  queries.read_out.begin_step();
  if (m_internalPreTickCallback != nullptr) m_internalPreTickCallback(this, time_step);
  reinitialize(time_step);
  applyRigidBodyGravity(time_step);
  predict(time_step);
  const PairGate gate(*getDispatcher(), *getPairCache(), getDispatchInfo());
  detect_rigid_contacts(gate);
  calculateSimulationIslands();
  beforeSolverCallbacks(time_step);
  solveConstraints(time_step);
  afterSolverCallbacks(time_step);

  const Span<btSoftBody* const> bodies = span_of(getSoftBodyArray());
  queries.find_contacts(bodies, gate);
  queries.read_contacts(bodies, *getBroadphase());
  if (!queries.read_out.apply_repulsion(bodies, time_step)) applyRepulsionForce(time_step);
  queries.prevent_crossings(bodies, gate, time_step);

  integrateTransforms(time_step);
  refit_face_trees(getSoftBodyArray());
  updateActions(time_step);
  updateActivationState(time_step);
  queries.read_out.finish(*getBroadphase());
}

}  // namespace softcd::bullet

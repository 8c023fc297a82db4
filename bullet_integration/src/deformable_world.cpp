#include "softcd/bullet/deformable_world.hpp"

#include "BulletCollision/CollisionDispatch/btCollisionDispatcher.h"
#include "contact_detection.hpp"
#include "crossing_prevention.hpp"
#include "native_trees.hpp"
#include "rigid_mesh_detection.hpp"

namespace softcd::bullet {

DeformableWorld::DeformableWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                                 btDeformableMultiBodyConstraintSolver* solver, btCollisionConfiguration* configuration,
                                 btDeformableBodySolver* deformable_solver, const Settings& settings)
    : btDeformableMultiBodyDynamicsWorld(dispatcher, broadphase, solver, configuration, deformable_solver),
      settings_(settings),
      detection_(std::make_unique<ContactDetection>(kDeformableWorld, settings)),
      prevention_(std::make_unique<CrossingPrevention>(kDeformableWorld, settings)),
      mesh_detection_(std::make_unique<RigidMeshDetection>(kDeformableWorld, settings)) {
  if (auto* bullets = dynamic_cast<btCollisionDispatcher*>(dispatcher)) install_pair_recorder(*bullets);
}

DeformableWorld::~DeformableWorld() = default;

void DeformableWorld::predict(btScalar time_step) {
  const TreesOutOfSight out_of_sight(getSoftBodyArray(), &btSoftBody::m_ndbvt);
  const FaceTreesUnbuilt unbuilt(getSoftBodyArray());
  predictUnconstraintMotion(time_step);
}

void DeformableWorld::detect_rigid_contacts() {
  // Bullet's own vertex-face test must not run beside ours; clusters go on.
  for (int i = 0; i < getSoftBodyArray().size(); ++i) getSoftBodyArray()[i]->m_softSoftCollision = false;
  updateAabbs();
  if (settings().rigid_meshes) {
    for (btSoftBody* body : span_of(getSoftBodyArray())) sweep_box(*body, *getBroadphase(), getDispatcher());
  }
  computeOverlappingPairs();
  for_each_near_rigid(*getPairCache(), refit_deformable_trees);
  mesh_detection_->around(*getDispatcher(), getDispatchInfo(), [this] {
    getDispatcher()->dispatchAllCollisionPairs(getPairCache(), getDispatchInfo(), getDispatcher());
  });
}

// The steps of Bullet's internalSingleStepSimulation.
void DeformableWorld::internalSingleStepSimulation(btScalar time_step) {
  if (m_internalPreTickCallback != nullptr) m_internalPreTickCallback(this, time_step);
  reinitialize(time_step);
  applyRigidBodyGravity(time_step);
  predict(time_step);
  detect_rigid_contacts();
  calculateSimulationIslands();
  beforeSolverCallbacks(time_step);
  solveConstraints(time_step);
  afterSolverCallbacks(time_step);

  const Span<btSoftBody* const> bodies = span_of(getSoftBodyArray());
  const PairGate gate(*getDispatcher(), *getPairCache(), getDispatchInfo());
  const PairRule rule = pair_rule(kDeformableWorld, gate, settings_);
  detection_->start(bodies, rule);
  detection_->finish();
  applyRepulsionForce(time_step);
  if (settings_.detection == Detection::ccd) prevention_->run(bodies, rule, time_step);

  integrateTransforms(time_step);
  refit_face_trees(getSoftBodyArray());
  updateActions(time_step);
  updateActivationState(time_step);
}

const Settings& DeformableWorld::settings() const {
  return settings_;
}

void DeformableWorld::set_settings(const Settings& settings) {
  detection_->set_settings(settings);
  prevention_->set_settings(settings);
  mesh_detection_->set_settings(settings);
  settings_ = settings;
}

const CollisionPipeline& DeformableWorld::pipeline() const {
  return detection_->pipeline();
}

const CollisionPipeline& DeformableWorld::continuous_pipeline() const {
  return prevention_->pipeline();
}

const std::vector<EdgeContact>& DeformableWorld::edge_contacts() const {
  return detection_->edge_contacts();
}

}  // namespace softcd::bullet

#include "softcd/bullet/soft_worlds.hpp"

#include "softcd/bullet/dispatcher.hpp"
#include "worlds/world_step.hpp"

namespace softcd::bullet {
namespace {

/// Returns the detection of a softcd::bullet::Dispatcher that serves the broad phase, or null.
WorldDetection* detection_of(btDispatcher* dispatcher, const btBroadphaseInterface* broadphase) {
  auto* ours = dynamic_cast<Dispatcher*>(dispatcher);
  return ours != nullptr && ours->serves(*broadphase) ? &ours->detection() : nullptr;
}

/// Does the first half of btCollisionWorld::performDiscreteCollisionDetection.
void find_pairs(const WorldStep& step) {
  step.world.updateAabbs();
  prepare_pairs(step);
  step.world.computeOverlappingPairs();
  for_each_near_rigid(*step.world.getPairCache(),
                      [](btSoftBody& body) { body.updateNodeTree(/*use_velocity=*/false, /*margin=*/true); });
}

/// Does the second half.
void process_pairs(btCollisionWorld& world) {
  world.getDispatcher()->dispatchAllCollisionPairs(world.getPairCache(), world.getDispatchInfo(),
                                                   world.getDispatcher());
}

}  // namespace

template <class BulletWorld>
SoftWorld<BulletWorld>::SoftWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase, ConstraintSolver* solver,
                                  btCollisionConfiguration* configuration, btSoftBodySolver* soft_body_solver,
                                  const Settings& settings)
    : BulletWorld(dispatcher, broadphase, solver, configuration, soft_body_solver),
      detection_(detection_of(dispatcher, broadphase)) {
  if (detection_ != nullptr) return;
  own_detection_ = std::make_unique<WorldDetection>(kClassicWorld, settings);
  own_detection_->queries_->broadphase = [this] { return this->getBroadphase(); };
  detection_ = own_detection_.get();
}

template <class BulletWorld>
SoftWorld<BulletWorld>::~SoftWorld() {
  for (btSoftBody* body : span_of(this->getSoftBodyArray())) give_face_tree(*body);
}

template <class BulletWorld>
void SoftWorld<BulletWorld>::predictUnconstraintMotion(btScalar time_step) {
  const NodeTreesAtRest at_rest(span_of(this->getSoftBodyArray()), kClassicTreeFlag);
  BulletWorld::predictUnconstraintMotion(time_step);
}

template <class BulletWorld>
void SoftWorld<BulletWorld>::performDiscreteCollisionDetection() {
  const WorldStep step{*this, this->getSoftBodyArray(), *detection_->queries_};
  find_pairs(step);
  if (own_detection_ != nullptr) {
    process_classic_pairs(step, [this] { process_pairs(*this); });
  } else {
    step.queries.prevents_crossings_later = true;
    process_pairs(*this);
    step.queries.keep_starts(step.body_span());
  }
}

template <class BulletWorld>
void SoftWorld<BulletWorld>::rayTest(const btVector3& from, const btVector3& to,
                                     btCollisionWorld::RayResultCallback& callback) const {
  detection_->queries_->rays.test(*this->m_broadphasePairCache, span_of(this->getSoftBodyArray()), from, to, callback,
                                  BulletWorld::rayTestSingle);
}

template <class BulletWorld>
void SoftWorld<BulletWorld>::internalSingleStepSimulation(btScalar time_step) {
  const WorldStep step{*this, this->getSoftBodyArray(), *detection_->queries_};
  const NodesInMotion in_motion(step.queries.rays);
  step.queries.read_out.begin_step();
  BulletWorld::internalSingleStepSimulation(time_step);
  finish_classic_step(step, time_step);
}

/// Bullet's step calls this last before it solves its soft bodies.
template <class BulletWorld>
void SoftWorld<BulletWorld>::updateActivationState(btScalar time_step) {
  BulletWorld::updateActivationState(time_step);
  prepare_classic_solver({*this, this->getSoftBodyArray(), *detection_->queries_});
}

template class SoftWorld<btSoftRigidDynamicsWorld>;
template class SoftWorld<btSoftMultiBodyDynamicsWorld>;

}  // namespace softcd::bullet

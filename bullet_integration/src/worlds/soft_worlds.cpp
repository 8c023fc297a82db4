#include "softcd/bullet/soft_worlds.hpp"

#include "native/at_end.hpp"
#include "softcd/bullet/dispatcher.hpp"
#include "worlds/step_driver.hpp"

namespace softcd::bullet {
namespace {

/// Returns the detection of a softcd::bullet::Dispatcher that serves the broad phase, or null.
WorldDetection* detection_of(btDispatcher* dispatcher, const btBroadphaseInterface* broadphase) {
  auto* ours = dynamic_cast<Dispatcher*>(dispatcher);
  return ours != nullptr && ours->serves(*broadphase) ? &ours->detection() : nullptr;
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
  const NodeTreesAtRest at_rest = ClassicStep(*this, this->getSoftBodyArray(), *detection_->queries_).predict();
  BulletWorld::predictUnconstraintMotion(time_step);
}

// Follows btCollisionWorld's function.
template <class BulletWorld>
void SoftWorld<BulletWorld>::performDiscreteCollisionDetection() {
  const ClassicStep step(*this, this->getSoftBodyArray(), *detection_->queries_);
  this->updateAabbs();
  step.pairs();
  this->computeOverlappingPairs();
  for_each_near_rigid(*this->getPairCache(),
                      [](btSoftBody& body) { body.updateNodeTree(/*use_velocity=*/false, /*margin=*/true); });
  const auto dispatch = [this] {
    this->getDispatcher()->dispatchAllCollisionPairs(this->getPairCache(), this->getDispatchInfo(),
                                                     this->getDispatcher());
  };
  if (own_detection_ != nullptr) {
    step.process(dispatch);
  } else {
    step.queries.prevents_crossings_later = true;
    dispatch();
    step.queries.keep_starts(step.bodies());
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
  const ClassicStep step(*this, this->getSoftBodyArray(), *detection_->queries_);
  step.queries.rays.begin_motion();
  const AtEnd motion_ends([&step] { step.queries.rays.end_motion(); });
  step.begin();
  BulletWorld::internalSingleStepSimulation(time_step);
  step.end(time_step);
}

/// Bullet's step calls this last before it solves its soft bodies.
template <class BulletWorld>
void SoftWorld<BulletWorld>::updateActivationState(btScalar time_step) {
  BulletWorld::updateActivationState(time_step);
  ClassicStep(*this, this->getSoftBodyArray(), *detection_->queries_).before_solver();
}

template class SoftWorld<btSoftRigidDynamicsWorld>;
template class SoftWorld<btSoftMultiBodyDynamicsWorld>;

}  // namespace softcd::bullet

#include "softcd/bullet/soft_worlds.hpp"

#include "native_trees.hpp"
#include "softcd/bullet/dispatcher.hpp"
#include "world_queries.hpp"

namespace softcd::bullet {
namespace {

using SoftBodies = btAlignedObjectArray<btSoftBody*>;

/// That of a softcd::bullet::Dispatcher that serves the broad phase; else null.
WorldDetection* detection_of(btDispatcher* dispatcher, const btBroadphaseInterface* broadphase) {
  auto* ours = dynamic_cast<Dispatcher*>(dispatcher);
  return ours != nullptr && ours->serves(*broadphase) ? &ours->detection() : nullptr;
}

/// Runs Bullet's prediction without its building or updating trees that nobody reads.
template <class Prediction>
void predict_without_trees(const SoftBodies& bodies, Prediction prediction) {
  for (btSoftBody* body : span_of(bodies)) hide_vertex_face_flag(*body);
  {
    const NodeTreesAtRest at_rest(bodies);
    prediction();
  }
  for (btSoftBody* body : span_of(bodies)) restore_vertex_face_flag(*body);
}

/// The first half of btCollisionWorld::performDiscreteCollisionDetection.
void find_pairs(btCollisionWorld& world, const SoftBodies& bodies, const Settings& settings) {
  world.updateAabbs();
  if (settings.rigid_meshes) {
    for (btSoftBody* body : span_of(bodies)) sweep_box(*body, *world.getBroadphase(), world.getDispatcher());
  }
  world.computeOverlappingPairs();
  for_each_near_rigid(*world.getPairCache(),
                      [](btSoftBody& body) { body.updateNodeTree(/*use_velocity=*/false, /*margin=*/true); });
}

void process_pairs_natively(btCollisionWorld& world) {
  world.getDispatcher()->dispatchAllCollisionPairs(world.getPairCache(), world.getDispatchInfo(),
                                                   world.getDispatcher());
}

/// The second half, with ours beside it.
void process_pairs(btCollisionWorld& world, const SoftBodies& bodies, WorldQueries& queries) {
  const PairGate gate(*world.getDispatcher(), *world.getPairCache(), world.getDispatchInfo());
  queries.process_pairs(span_of(bodies), gate, [&] {
    const TreesOutOfSight out_of_sight(bodies, &btSoftBody::m_fdbvt);
    if (!out_of_sight.succeeded()) {
      // Those that there are belong to ray tests, which build new ones.
      for (btSoftBody* body : span_of(bodies)) body->m_fdbvt.clear();
    }
    process_pairs_natively(world);
  });
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
  predict_without_trees(this->getSoftBodyArray(), [&] { BulletWorld::predictUnconstraintMotion(time_step); });
}

template <class BulletWorld>
void SoftWorld<BulletWorld>::performDiscreteCollisionDetection() {
  find_pairs(*this, this->getSoftBodyArray(), detection_->settings());
  if (own_detection_ != nullptr) {
    process_pairs(*this, this->getSoftBodyArray(), *own_detection_->queries_);
    own_detection_->queries_->read_contacts(span_of(this->getSoftBodyArray()), *this->getBroadphase());
  } else {
    process_pairs_natively(*this);
  }
}

template <class BulletWorld>
void SoftWorld<BulletWorld>::internalSingleStepSimulation(btScalar time_step) {
  WorldQueries& queries = *detection_->queries_;
  queries.read_out.begin_step();
  BulletWorld::internalSingleStepSimulation(time_step);
  queries.read_out.take_rehearsed_impulses();
  const PairGate gate(*this->getDispatcher(), *this->getPairCache(), this->getDispatchInfo());
  queries.prevent_crossings(span_of(this->getSoftBodyArray()), gate, time_step);
  queries.read_out.finish(*this->getBroadphase());
}

/// The last that Bullet's step does before it solves its soft bodies.
template <class BulletWorld>
void SoftWorld<BulletWorld>::updateActivationState(btScalar time_step) {
  BulletWorld::updateActivationState(time_step);
  detection_->queries_->read_out.rehearse_solver(span_of(this->getSoftBodyArray()));
}

template class SoftWorld<btSoftRigidDynamicsWorld>;
template class SoftWorld<btSoftMultiBodyDynamicsWorld>;

}  // namespace softcd::bullet

#pragma once

#include <memory>

#include "contact_detection.hpp"
#include "crossing_prevention.hpp"
#include "native_trees.hpp"
#include "rigid_mesh_detection.hpp"
#include "softcd/bullet/dispatcher.hpp"

class btCollisionWorld;

namespace softcd::bullet {

/// What the one-line worlds do around Bullet's prediction and in place of its collision detection.
class SoftWorldHooks {
 public:
  SoftWorldHooks(btDispatcher* dispatcher, const Settings& settings);

  /// Runs Bullet's prediction without its building or updating trees that nobody reads.
  template <class Prediction>
  void predict(const btAlignedObjectArray<btSoftBody*>& bodies, Prediction prediction) {
    for (int i = 0; i < bodies.size(); ++i) hide_vertex_face_flag(*bodies[i]);
    {
      const NodeTreesAtRest at_rest(bodies);
      prediction();
    }
    for (int i = 0; i < bodies.size(); ++i) restore_vertex_face_flag(*bodies[i]);
  }

  /// btCollisionWorld::performDiscreteCollisionDetection with ours beside it.
  void detect(btCollisionWorld& world, const btAlignedObjectArray<btSoftBody*>& bodies);

  /// After Bullet's step, where Settings::detection is ccd: see CrossingPrevention.
  void prevent_crossings(btCollisionWorld& world, const btAlignedObjectArray<btSoftBody*>& bodies, btScalar time_step);

  /// The detection in use: the dispatcher's where that is a softcd::bullet::Dispatcher.
  const Settings& settings() const;
  void set_settings(const Settings& settings);
  const CollisionPipeline& pipeline() const;
  const std::vector<EdgeContact>& edge_contacts() const;

 private:
  Dispatcher* dispatcher_;  ///< null for any other dispatcher
  Settings settings_;
  /// Null when dispatcher_ detects.
  std::unique_ptr<ContactDetection> detection_;
  std::unique_ptr<RigidMeshDetection> mesh_detection_;
  CrossingPrevention prevention_;
};

}  // namespace softcd::bullet

#pragma once

#include <cstdint>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/version.hpp"

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// One side of a contact: a point on a feature of a body.
struct ContactSide {
  /// The kind of feature.
  enum class Feature : std::uint32_t {
    node,    ///< nodes[0]
    edge,    ///< between nodes[0] and nodes[1]; Bullet has no number for it
    face,    ///< `face`, with the nodes nodes[0] to nodes[2]
    object,  ///< a rigid object; Bullet does not distinguish its parts
  };
  Feature feature = Feature::node;  ///< the kind of feature
  int nodes[3] = {-1, -1, -1};      ///< in the body's m_nodes; -1 where the feature has none
  btScalar weights[3] = {0, 0, 0};  ///< of those nodes at the contact; of a face they may be a little outside [0, 1]
  int face = -1;                    ///< in the body's m_faces; -1 unless the feature is a face
  /// The point, in world coordinates, at the time for which the solver got the contact: the predicted end of the step
  /// in classic worlds, its start in the deformable world.
  btVector3 position{0, 0, 0};
};

/// One contact that Bullet's solver got in a step.
struct BodyContact {
  ContactSide a;              ///< on BodyPairContacts::a
  ContactSide b;              ///< on BodyPairContacts::b
  btVector3 normal{0, 0, 0};  ///< unit vector from b towards a
  /// Depth along the normal, relative to the distance that the solver wants: the sum of both margins, or the soft
  /// body's margin if b is a rigid object. Negative while the two are further apart.
  btScalar depth = 0;
  /// Time of impact in [0, 1] of the step, for contacts from continuous detections: Detection::ccd in classic worlds,
  /// and rigid meshes. Otherwise 1.
  btScalar time_of_impact = 1;
  /// Impulses on a and b from this contact in the step, kg m/s, friction included. Divided by the step's length they
  /// are mean forces. 0 for nodes without mass. [In a Bullet world](docs/use/bullet.md) says how exact they are in each
  /// kind of world. Valid if BodyPairContacts::has_impulses.
  btVector3 impulse_a{0, 0, 0};
  btVector3 impulse_b{0, 0, 0};  ///< see impulse_a
  bool is_new = false;           ///< these features were not in contact before
};

/// All contacts of a soft body with another object, or with itself.
struct BodyPairContacts {
  /// The change since the step with which the pair is compared.
  enum class State : std::uint32_t { begun, persists, ended };

  /// The soft body; null if it has left the world since the step.
  btSoftBody* a = nullptr;
  const btCollisionObject* b = nullptr;  ///< the other object, or `a` for contacts within a body; null like `a`
  State state = State::begun;            ///< whether contact has begun, persists or has ended
  /// The contacts of the last step. Empty if the pair has ended, or if only the last pass of Detection::ccd kept the
  /// two apart.
  std::vector<BodyContact> contacts;
  std::vector<BodyContact> ended;  ///< contacts that have ended, as they were before
  /// Impulse on a from b: the sum over `contacts`, plus that of the last pass of the step. If a node would have crossed
  /// several bodies in that pass, each has an equal share.
  btVector3 impulse_a{0, 0, 0};
  btVector3 impulse_b{0, 0, 0};  ///< impulse on b from a
  /// Whether the impulses are known; if not they are 0. They are unknown
  /// - without ReadOut::impulses;
  /// - under a Dispatcher alone, which does not see the solver;
  /// - in classic worlds, for bodies that something besides Bullet's constraint solver moves (colliding clusters, the
  ///   app's own soft body solver, a tick callback);
  /// - in the deformable world, for contacts of reduced bodies with rigid objects.
  bool has_impulses = false;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet

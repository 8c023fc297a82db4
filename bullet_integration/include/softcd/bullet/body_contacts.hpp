#pragma once

#include <cstdint>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/version.hpp"

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// One side of a contact: where on which part of which body.
struct ContactSide {
  /// Which part of the body it is.
  enum class Feature : std::uint32_t {
    node,    ///< nodes[0]
    edge,    ///< between nodes[0] and nodes[1]; Bullet has no number for it
    face,    ///< `face`, with the nodes nodes[0] to nodes[2]
    object,  ///< a rigid object, whose parts Bullet does not tell apart
  };
  Feature feature = Feature::node;  ///< which part touches
  int nodes[3] = {-1, -1, -1};      ///< in the body's m_nodes; -1 where the feature has none
  btScalar weights[3] = {0, 0, 0};  ///< of those nodes at the contact; of a face they may be a little outside [0, 1]
  int face = -1;                    ///< in the body's m_faces; -1 unless the feature is a face
  /// In the world, as Bullet's solver got the contact: in classic worlds where the step was predicted to end, in the
  /// deformable world where it begins.
  btVector3 position{0, 0, 0};
};

/// One contact that Bullet's solver was given in a step.
struct BodyContact {
  ContactSide a;              ///< on BodyPairContacts::a
  ContactSide b;              ///< on BodyPairContacts::b
  btVector3 normal{0, 0, 0};  ///< unit vector from b towards a
  /// How much closer along the normal the two positions are than the solver wants them: than the margins of soft
  /// bodies, and of the soft body alone where b is an object. Negative for a contact that is only about to be.
  btScalar depth = 0;
  /// In [0, 1] of the step, as softcd::Contact has it, where softcd has looked at the way of the step: with
  /// Detection::ccd in classic worlds, and at rigid meshes. Else 1.
  btScalar time_of_impact = 1;
  /// What the solver gave to a and to b through this contact in the step, mass times velocity, friction included. Over
  /// the length of the step it is the mean force. Nothing for nodes without mass. In the classic worlds, where the
  /// solver moves nodes, it is mass times displacement over the length of the step: what they gain in momentum from
  /// where the step began to where it ends, exactly but for rounding, on both sides, which Bullet's formulas do not
  /// always make opposite. In the deformable world likewise, with rigid objects as far as Bullet's iterative solver
  /// converges; under attach(), and with an implicit solver, a soft body's impulse from a rigid object leaves out what
  /// the solver does with the forces within the body. An object that no impulse moves gets the opposite of what the
  /// soft body gets. A body that sleeps has the impulses of the last step in which it was awake. The shifts of
  /// positions by split impulses, which end with the step, are no impulses of contacts. What Detection::ccd does last,
  /// so that nothing passes through anything, is no contact's: BodyPairContacts::impulse_a has it. See
  /// BodyPairContacts::has_impulses.
  btVector3 impulse_a{0, 0, 0};
  btVector3 impulse_b{0, 0, 0};  ///< see impulse_a
  bool is_new = false;           ///< the same parts of the two bodies were not in contact before
};

/// All contacts of a soft body with another body, or with itself.
struct BodyPairContacts {
  /// What has become of the pair since the step that it is compared with.
  enum class State : std::uint32_t { begun, persists, ended };

  /// Null when the body is not in the world any more, which pairs that have ended and those of a step that is over may
  /// show.
  btSoftBody* a = nullptr;
  const btCollisionObject* b = nullptr;  ///< the same as `a` for contacts within a body; null as `a`
  State state = State::begun;            ///< whether they have just begun to touch
  /// The contacts of the last step. Empty when the pair has ended, and where only the last pass of Detection::ccd kept
  /// the two apart.
  std::vector<BodyContact> contacts;
  std::vector<BodyContact> ended;  ///< those that were there before, as they were then
  /// The sum over `contacts`, and what a was given last in a step with Detection::ccd so that it does not pass through
  /// b. Where a node would have met several bodies, each has an equal share.
  btVector3 impulse_a{0, 0, 0};
  btVector3 impulse_b{0, 0, 0};  ///< likewise
  /// Whether the impulses are known. They are all zero where not: without ReadOut::impulses; under a
  /// softcd::bullet::Dispatcher alone, which does not see the solver; in classic worlds for bodies that something
  /// else than Bullet's solver of constraints moves at the same time (clusters that collide, a soft body solver of the
  /// app's, a tick callback); and in the deformable world for contacts of reduced bodies with rigid objects.
  bool has_impulses = false;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet

#pragma once

#include "contacts/contacts_of_kind.hpp"
#include "crossings/crossings_of_kind.hpp"
#include "native/native_detection.hpp"
#include "native/native_trees.hpp"
#include "questions/ray_mesh.hpp"
#include "read_out/contact_reader.hpp"

namespace softcd::bullet {

/// All differences between the kinds of world, by subject. No other code asks which kind a world is.
struct WorldKind {
  const ContactsOfKind& contacts;
  const CrossingsOfKind& crossings;
  TreeFlag tree_flag;
  /// The features that the world's ray tests hit.
  RayTargets ray_targets;
  /// The world's choice where the app leaves it.
  EdgeContacts automatic_edge_contacts;
  /// Whether Bullet moves rigid bodies before it solves soft ones. Then impulses of soft bodies move rigid ones from
  /// the next step on.
  bool moves_rigid_bodies_first;
  /// Reads a body's contacts, of all kinds, from Bullet's arrays.
  ReadContacts read_contacts;
  /// Bullet's own detection, for a step in which softcd's has failed.
  void (*detect_natively)(Span<btSoftBody* const>, const PairGate&, const PairRule&);
};

/// btSoftRigidDynamicsWorld and btSoftMultiBodyDynamicsWorld.
extern const WorldKind kClassicWorld;
/// btDeformableMultiBodyDynamicsWorld.
extern const WorldKind kDeformableWorld;

}  // namespace softcd::bullet

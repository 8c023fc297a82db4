#pragma once

#include <functional>
#include <unordered_map>
#include <vector>

#include "contact_reader.hpp"
#include "contact_writer.hpp"
#include "impact_zones.hpp"
#include "pair_gate.hpp"
#include "softcd/bullet/settings.hpp"
#include "world_rays.hpp"

namespace softcd::bullet {

/// The bodies whose nodes' velocities were changed so that they do not pass through each other, with what their nodes
/// had before.
struct NodeStates {
  std::vector<btVector3> velocities, split_velocities, ends;
};
using AnsweredBodies = std::unordered_map<btSoftBody*, NodeStates>;

/// All that differs between the kinds of world. Nobody asks in another way which kind a world is.
struct WorldKind {
  /// Of btSoftBody::fCollision: bodies whose contacts of vertices with faces softcd finds.
  int vertex_face_flag;
  /// Where the nodes are at the step's ends while softcd looks for contacts and crossings.
  NodePosition start, end;
  /// What Bullet's ray tests of the world look at.
  RayTargets ray_targets;

  /// Whether bodies are solved in turns, with the links of each: what is not a number in a body is so everywhere in it
  /// when the step ends, and in all that it touches.
  bool solves_in_turns;

  /// Whether what soft bodies do to rigid ones in a step moves these from the next step on.
  bool moves_rigid_bodies_first;

  /// How contacts between soft bodies are looked for.
  QueryOptions (*contact_options)(const Settings&);
  /// Whether PairGate is asked about pairs of soft bodies.
  bool (*asks_gate)(const Settings&);
  /// Whether write_contact would put a contact into Bullet's arrays.
  bool (*is_written)(const MemberContact&, Detection);
  /// Whether Bullet's solver may have something to do for a contact that is written.
  bool (*may_close)(const MemberContact&);
  /// By how much the margin of the contact that answers for several, itself included, is cut.
  btScalar (*margin_cut)(const MemberContact& one, const std::vector<MemberContact>& several, Detection);
  /// Put a contact into Bullet's arrays: see contact_writer.hpp. A vertex-face contact may answer for several.
  void (*write_contact)(const MemberContact&, Detection, const ContactShare&);
  void (*write_edge_contact)(const MemberContact&);
  /// How many contacts with faces of soft bodies the body's array has.
  int (*soft_contact_count)(const btSoftBody&);
  /// Reads a body's contacts, of all kinds, from Bullet's arrays.
  void (ContactReader::*read_contacts)(const btSoftBody&, std::vector<ReadContact>&) const;
  /// Bullet's own detection, for a step in which softcd's has failed.
  void (*detect_natively)(Span<btSoftBody* const>, const PairGate&, const Settings&);

  /// What CrossingPrevention does to a body: before it looks for the first time; before it answers an impact of the
  /// body for the first time; and after each change of velocities, to bring the nodes' `end` to where these lead.
  void (*set_out)(btSoftBody&, btScalar time_step);
  void (*take_up)(btSoftBody&, btScalar time_step);
  void (*move_end)(btSoftBody&, btScalar time_step);
  /// Of a node, what moves its `end` in this step alone, and is gone when the ends stand.
  btVector3 btSoftBody::Node::*passing_velocity;
  /// By what a node's mean velocity in the step, or its own in the deformable world, has changed: what
  /// BodyContact::impulse_a counts.
  btVector3 (*velocity_change)(const btSoftBody::Node&, const NodeStates& before, std::size_t index,
                               btScalar time_step);
  /// After move_end: to leave a node where the step began, with its velocity.
  void (*hold)(btSoftBody::Node&);
  /// And to all of them when the ends stand: `impacts` and `zones` are those that were answered.
  void (*settle)(const AnsweredBodies&, const std::vector<Impact>& impacts, ImpactZones& zones);
};

/// btSoftRigidDynamicsWorld and btSoftMultiBodyDynamicsWorld: contacts are looked for when the nodes have been moved.
extern const WorldKind kClassicWorld;
/// btDeformableMultiBodyDynamicsWorld: contacts are looked for before the nodes move.
extern const WorldKind kDeformableWorld;

/// Where the body's nodes are when the step begins. A body that sleeps was not predicted: its m_q means nothing.
inline NodePosition start_of(const WorldKind& kind, const btSoftBody& body) {
  return body.isActive() ? kind.start : &btSoftBody::Node::m_x;
}

/// Whether softcd, not Bullet, is responsible for the contacts of a pair, or of a body with itself: Bullet's own rule.
inline bool is_vertex_face_pair(const WorldKind& kind, const btSoftBody& a, const btSoftBody& b) {
  return (a.m_cfg.collisions & b.m_cfg.collisions & btSoftBody::fCollision::SVSmask) == kind.vertex_face_flag;
}

/// Whether softcd looks after the contacts of two soft bodies.
using PairRule = std::function<bool(btSoftBody&, btSoftBody&)>;

inline bool is_looked_after(const WorldKind& kind, const PairGate& gate, const Settings& settings, btSoftBody& a,
                            btSoftBody& b) {
  return is_vertex_face_pair(kind, a, b) && (!kind.asks_gate(settings) || gate.admits(a, b));
}

/// `kind`, `gate` and `settings` outlive the rule.
inline PairRule pair_rule(const WorldKind& kind, const PairGate& gate, const Settings& settings) {
  return [&](btSoftBody& a, btSoftBody& b) { return is_looked_after(kind, gate, settings, a, b); };
}

/// What a query of the mirror's scene asks, whose rule this is. `mirror` and `rule` outlive the filter. A body may
/// touch itself where its settings say so.
inline PairFilter pair_filter(const WorldMirror& mirror, const PairRule& rule) {
  return [&](BodyId a, BodyId b) {
    if (a == b) return true;
    const WorldMirror::Member* const member_a = mirror.find(a);
    const WorldMirror::Member* const member_b = mirror.find(b);
    return member_a != nullptr && member_b != nullptr && rule(*member_a->body, *member_b->body);
  };
}

inline bool has_vertex_face_contacts(const WorldKind& kind, const btSoftBody& body) {
  return (body.m_cfg.collisions & kind.vertex_face_flag) != 0 && body.m_nodes.size() > 0;
}

/// Margin, self-collision, features and whether the body can be moved by contacts, as they are now.
BodySettings read_settings(const WorldKind& kind, const btSoftBody& body, const Settings& settings);

}  // namespace softcd::bullet

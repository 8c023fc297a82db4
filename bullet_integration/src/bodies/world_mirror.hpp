#pragma once

#include <unordered_map>
#include <vector>

#include "bodies/body_key.hpp"
#include "bodies/body_mesh.hpp"
#include "bodies/node_ends.hpp"
#include "bodies/rigid_mirror.hpp"
#include "bodies/vectors.hpp"
#include "native/pair_gate.hpp"
#include "softcd/bullet/body_filters.hpp"
#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

/// A world's soft bodies, and the rigid parts near them, as a scene that all of the world's queries share. Once a step
/// it notices what an app has done to them between two steps (adding, removing, deleting them, new faces, flags,
/// margins). It has only bodies that a query needs. Owned by WorldQueries. A WorldProbe has another one, with
/// kPresentEnds, and resumes a step before each question.
class WorldMirror {
 public:
  struct Member {
    btSoftBody* body = nullptr;
    BodyId id;
    BodyMesh mesh;
    BodySettings settings;
    std::uint64_t filters = 0;        ///< the number of the filters that the scene has, or 0
    bool is_outdated = false;         ///< whether the mesh differed when it was last compared
    bool topology_changed = false;    ///< since the last step
    bool is_in_parts = false;         ///< used by a Dispatcher: see replace_face_tree()
    std::uint64_t last_compared = 0;  ///< the step, or 0 to compare again
    std::uint64_t last_step = 0;      ///< in which a query needed it
    bool has_way = false;             ///< whether the scene has both ends of this step
    std::vector<Vec3<btScalar>> x;    ///< with kPresentEnds: as the scene has them
    bool is_in_world = false;

    btSoftBody::Node& node(std::uint32_t index) const { return body->m_nodes[static_cast<int>(index)]; }
    btSoftBody::Face& face(std::uint32_t index) const { return body->m_faces[static_cast<int>(index)]; }
    Vec3d place(std::uint32_t index, NodePosition position) const { return to_doubles(node(index).*position); }
    /// Returns a face for Bullet's contacts at an edge that joins two nodes and is numbered as in Contact. The face is
    /// one of the body's, or one that represents a link.
    btSoftBody::Face& face_at_edge(std::uint32_t edge, const std::uint32_t* nodes) const {
      if (!mesh.link_faces.empty()) return link_face(edge);
      return face(bullet::face_at_edge(mesh, nodes[0], nodes[1]));
    }
    btSoftBody::Face& link_face(std::uint32_t edge) const {
      return const_cast<btSoftBody::Face&>(mesh.link_faces[edge]);
    }
  };

  /// `ends` and `settings` are the world's and must outlive it. Throws as Scene's constructor does.
  WorldMirror(const NodeEnds& ends, const Settings& settings);
  WorldMirror(const WorldMirror&) = delete;
  WorldMirror& operator=(const WorldMirror&) = delete;

  /// Applies changed settings. Throws as Scene::set_options does.
  void follow_settings();
  /// Throws InvalidInput; see WorldDetection.
  void set_filters(const btSoftBody& body, BodyFilters filters);
  Scene& scene() { return scene_; }
  /// Returns the rigid parts in the scene.
  RigidMirror& rigid() { return rigid_; }

  /// Begins a step: `bodies` are the world's soft bodies now. Call it before require(), which accepts these bodies and
  /// proxies of rigid().
  void begin_step(Span<btSoftBody* const> bodies) noexcept;
  /// Resumes a step after the app could change the world: `bodies` are still there, and may have other faces and
  /// settings.
  void resume_step(Span<btSoftBody* const> bodies) noexcept;
  /// Compares topologies of all bodies in parallel. This is the longest part of require().
  void compare(Span<btSoftBody* const> bodies);
  /// Brings the body in the scene up to date with this step: with its positions at the step's start and, if
  /// `needs_way`, at its end.
  Member& require(btSoftBody& body, bool needs_way);
  /// Returns whether require() was called for the body in this step.
  bool has(const btSoftBody& body) const;
  /// Updates both ends of a member's step after the nodes' end positions have changed.
  void update_way(Member& member);

  /// Makes all bodies new in the next step. Needed after a query has failed, as the scene may not have read all
  /// positions.
  void forget_all() { forgets_all_ = true; }

  /// Returns null if no soft body has the id.
  const Member* find(BodyId id) const;
  Member& member(BodyId id) const { return *members_by_id_.at(id.value); }
  Member& member(const btSoftBody& body) { return members_.at(BodyKey(body)); }

  /// Calls visit(const MemberContact&) for each contact between soft bodies, in order.
  template <class Visit>
  void for_each_contact(Span<const Contact> contacts, Visit visit) const;

 private:
  /// A body's filters, and its nodes' positions when the filters were set.
  struct KeptFilters {
    BodyFilters filters;
    std::vector<Vec3d> x_rest;
    std::uint64_t number = 0;
    bool is_in_world = false;
  };

  void keep_filters_of(Span<btSoftBody* const> bodies) noexcept;
  void drop_unfit_filters(const btSoftBody& body);
  BodySettings settings_of(const btSoftBody& body) const;
  void pass_on_filters(Member& member);
  Member& add(btSoftBody& body, const BodySettings& settings);
  void update(Member& member, const BodySettings& settings);
  void update_mesh(Member& member, const BodySettings& settings);
  void compare(Member& member) const;
  void set_positions(Member& member, bool needs_way);
  /// Returns whether the mirror has kPresentEnds.
  bool is_outside_steps() const { return ends_.start == ends_.end; }
  static bool has_moved(Member& member);
  template <class Predicate>
  void keep(Span<btSoftBody* const> bodies, Predicate is_kept) noexcept;

  const NodeEnds& ends_;
  const Settings& settings_;
  Scene scene_;
  RigidMirror rigid_;
  std::unordered_map<BodyKey, Member, BodyKeyHash> members_;
  std::unordered_map<std::uint32_t, Member*> members_by_id_;
  std::unordered_map<BodyKey, KeptFilters, BodyKeyHash> filters_;
  std::uint64_t last_filters_ = 0;
  std::uint64_t step_ = 1;
  bool forgets_all_ = false;
};

/// Returns how many of the contact's vertices are side a's. Those of side b follow.
inline int vertices_of_a(const Contact& contact) {
  return contact.kind == ContactKind::vertex_triangle ? 1 : 2;
}

/// A contact with the members that its two sides belong to.
struct MemberContact {
  const Contact& contact;
  const WorldMirror::Member& a;
  const WorldMirror::Member& b;

  bool is_of_a(int vertex) const { return vertex < vertices_of_a(contact); }
  /// Returns the node at one of the contact's four vertices.
  btSoftBody::Node& node(int vertex) const { return (is_of_a(vertex) ? a : b).node(contact.vertices[vertex]); }
  /// Returns side b of a contact of a node with a face.
  btSoftBody::Face& face() const { return b.face(contact.feature_b); }
};

/// Returns whether side b is a face. Triangles after a body's faces represent single nodes, and Bullet has no contacts
/// with these.
inline bool is_with_face(const MemberContact& found) {
  return found.contact.feature_b < found.b.mesh.face_count;
}

/// Returns `rule` as a filter for queries of the mirror's scene. `mirror` and `rule` must outlive it. It admits a body
/// with itself, which the body's settings decide.
inline PairFilter pair_filter(const WorldMirror& mirror, const PairRule& rule) {
  return [&](BodyId a, BodyId b) {
    if (a == b) return true;
    const WorldMirror::Member* const member_a = mirror.find(a);
    const WorldMirror::Member* const member_b = mirror.find(b);
    return member_a != nullptr && member_b != nullptr && rule(*member_a->body, *member_b->body);
  };
}

template <class Visit>
void WorldMirror::for_each_contact(Span<const Contact> contacts, Visit visit) const {
  const Member* a = nullptr;
  const Member* b = nullptr;
  for (const Contact& contact : contacts) {
    if (a == nullptr || a->id != contact.body_a) a = &member(contact.body_a);
    if (b == nullptr || b->id != contact.body_b) b = &member(contact.body_b);
    visit(MemberContact{contact, *a, *b});
  }
}

}  // namespace softcd::bullet

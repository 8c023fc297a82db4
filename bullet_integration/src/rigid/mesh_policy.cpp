#include "rigid/mesh_policy.hpp"

#include <algorithm>

#include "BulletCollision/CollisionShapes/btConcaveShape.h"
#include "bodies/query_options.hpp"
#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

using Flags = btSoftBody::fCollision;

/// Contacts of a node with a mesh whose normals are closer than this (8 degrees) count as one: on a smooth surface a
/// node touches several triangles at the same time.
constexpr btScalar kSameNormal = btScalar(0.99);

/// Nodes that contacts push in nearly a touch's direction (within 26 degrees) also keep off the surface between them.
constexpr btScalar kNearlySameNormal = btScalar(0.9);

/// Share of the margin at which corners and edges of a mesh hold faces. Nodes are held at the whole margin. On ground
/// that is coarser than a cloth, corners are within the margin of most faces, and need no contact of their own.
constexpr btScalar kFaceMarginShare = btScalar(0.5);

/// Returns whether edges of faces get contacts with edges of meshes. In classic worlds CrossingPrevention keeps them
/// apart.
bool holds_faces(const ContactsOfKind& kind) {
  return !kind.solves_in_turns;
}

/// Returns whether Bullet's solver would use contacts of faces and links, if it is the deformable one.
bool solves_faces(const btSoftBody& soft, const btCollisionObject& object) {
  return !has_deformable_contacts(soft) || ((soft.m_cfg.collisions & (Flags::SDF_RDN | Flags::SDF_RDF)) != 0 &&
                                            object.getInternalType() == btCollisionObject::CO_RIGID_BODY);
}

}  // namespace

QueryOptions MeshPolicy::options(const ContactsOfKind& kind, const Settings& settings) {
  QueryOptions options = continuous_options(settings);
  options.features = {/*vertex_triangle=*/true, holds_faces(kind) || settings.edge_contacts == EdgeContacts::respond};
  return options;
}

void MeshPolicy::require(const RigidKey& key, Span<const RigidPair> pairs, btScalar time_step,
                         const ReadsWhole& reads_whole, RigidParts<RigidMesh>& parts) {
  const auto& shape = static_cast<const btConcaveShape&>(*pairs[0].shape);
  const RigidPoses poses = poses_of(*pairs[0].object, pairs[0].shape_in_object, time_step);
  const bool has_edges = holds_faces(kind_) || std::any_of(pairs.begin(), pairs.end(), [this](const RigidPair& pair) {
                           return !mirror_.member(*pair.soft).mesh.segments.empty();
                         });
  std::vector<Bounds> boxes;
  for (const RigidPair& pair : pairs) {
    const btScalar margin = margin_of(*pair.soft) + shape.getMargin();
    boxes.push_back(box_in_shape(swept_box(*pair.soft, margin), poses));
  }
  const RigidPart<RigidMesh>* const known = parts.find(key);
  const bool is_whole = known != nullptr && std::any_of(pairs.begin(), pairs.end(), [&](const RigidPair& pair) {
                          return reads_whole(*pair.soft, known->id);
                        });
  const auto read = [&](RigidMesh& mesh) { return is_whole ? mesh.read_whole(shape) : mesh.read(shape, boxes); };
  const auto& mesh = parts.require(key, *pairs[0].object, shape.getMargin(), has_edges, poses, read);
  for (const RigidPair& pair : pairs) parts.want(mesh, *pair.soft, mirror_.member(*pair.soft).id);
}

void MeshPolicy::begin_contacts(Span<const NearRigidPart> /*near_parts*/, const TangledNodes* released) {
  released_ = released;
  tests_edges_ = options(kind_, settings_).features.edge_edge;
  corner_touches_.clear();
  edge_touches_.clear();
  node_normals_.clear();
  node_touches_.clear();
}

void MeshPolicy::take(const MeshContact& found) {
  if (is_released(found)) return;
  if (found.contact.kind == ContactKind::edge_edge) {
    find_edge_touch(found);
  } else if (found.is_part_a) {
    find_face_touch(found);
  } else {
    find_node_touch(found);
  }
}

void MeshPolicy::end_contacts() {
  add_node_touches();
  add_corner_touches();
  add_edge_touches();
}

void MeshPolicy::find_node_touch(const MeshContact& found) {
  btSoftBody& soft = *found.soft.body;
  btSoftBody::Node& node = found.soft.node(found.contact.feature_a);
  const bool is_of_others =
      !node_touches_.empty() && (node_touches_[0].node != &node || node_touches_[0].mesh != found.part.id);
  if (is_of_others) add_node_touches();
  if (!takes_node_contacts(soft, node)) return;
  const RigidTouch touch = found.touch(found.margin());
  const btScalar depth_at_end = depth(touch, node.*kind_.ends.end, touch.object_point_t1);
  if (depth_at_end < 0) node_touches_.push_back({&soft, &node, found.part.id, touch, depth_at_end});
}

/// Returns whether a node of the soft body moves out of the object.
bool MeshPolicy::is_released(const MeshContact& found) const {
  if (released_ == nullptr || released_->empty()) return false;
  const std::uint32_t* const begin = found.contact.vertices + found.first_of_soft();
  return std::any_of(begin, begin + found.count_of_soft(),
                     [&](std::uint32_t node) { return released_->has(found.soft.node(node), *found.part.object); });
}

/// Adds the deepest touch in each distinct direction, of one node's touches with one mesh.
void MeshPolicy::add_node_touches() {
  std::stable_sort(node_touches_.begin(), node_touches_.end(),
                   [](const NodeTouch& a, const NodeTouch& b) { return a.depth_at_end < b.depth_at_end; });
  auto end_of_kept = node_touches_.begin();
  for (const NodeTouch& each : node_touches_) {
    const RigidTouch& touch = each.touch;
    const bool is_known = std::any_of(node_touches_.begin(), end_of_kept, [&](const NodeTouch& kept) {
      return kept.touch.normal.dot(touch.normal) > kSameNormal;
    });
    if (is_known) continue;
    touches_.add(*each.soft, *each.node, touch);
    if (tests_edges_) node_normals_.emplace(std::pair(each.node, touch.object), touch.normal);
    *end_of_kept++ = each;
  }
  node_touches_.clear();
}

void MeshPolicy::find_face_touch(const MeshContact& found) {
  btSoftBody& soft = *found.soft.body;
  if (!has_deformable_contacts(soft) || !solves_faces(soft, *found.part.object)) return;
  if (found.contact.feature_b >= found.soft.mesh.face_count) return;
  btSoftBody::Face& face = found.soft.face(found.contact.feature_b);
  const btVector3 weights = triangle_weights(found.contact.weights);
  const bool is_tested_by_bullet = (soft.m_cfg.collisions & Flags::SDF_RDF) != 0;
  const RigidTouch touch = found.touch(found.margin() * (is_tested_by_bullet ? 1 : kFaceMarginShare));
  if (depth(touch, point_on(face, weights, kind_.ends.end), touch.object_point_t1) >= 0) return;
  if (is_tested_by_bullet) {
    touches_.add(soft, face, weights, touch);
  } else {
    corner_touches_.push_back({&soft, &face, weights, touch});
  }
}

void MeshPolicy::add_corner_touches() {
  for (const auto& [soft, face, weights, touch] : corner_touches_) {
    if (!are_held(*face, weights, touch, kNearlySameNormal)) touches_.add(*soft, *face, weights, touch);
  }
}

void MeshPolicy::find_edge_touch(const MeshContact& found) {
  const WorldMirror::Member& member = found.soft;
  const bool is_link = !member.mesh.segments.empty();
  const bool is_answered = is_link ? settings_.edge_contacts == EdgeContacts::respond
                                   : holds_faces(kind_) && has_deformable_contacts(*member.body);
  if (!is_answered) return;
  if (!found.is_inside_edges() || !solves_faces(*member.body, *found.part.object)) return;
  const std::uint32_t edge = found.is_part_a ? found.contact.feature_b : found.contact.feature_a;
  const std::uint32_t* const nodes = found.contact.vertices + found.first_of_soft();
  const RigidTouch touch = found.touch(found.margin() * (is_link ? 1 : kFaceMarginShare));
  btSoftBody::Face& face = member.face_at_edge(edge, nodes);
  const btVector3 weights = weights_on_edge(face, *member.body, nodes, found.contact.weights + found.first_of_soft());
  const btScalar depth_at_end = depth(touch, point_on(face, weights, kind_.ends.end), touch.object_point_t1);
  const btScalar least_cosine = is_link ? kSameNormal : kNearlySameNormal;
  if (depth_at_end < 0 && !are_held(face, weights, touch, least_cosine)) {
    edge_touches_[{member.id.value, edge, found.part.id.value}].push_back({&face, touch, weights, depth_at_end});
  }
}

/// Returns whether all nodes with a weight have contacts that push them off the object in that direction. This is the
/// case on a flat surface, whose triangles have corners and edges, too.
bool MeshPolicy::are_held(const btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch,
                          btScalar least_cosine) const {
  const auto is_held = [&](const btSoftBody::Node* node) {
    const auto [begin, end] = node_normals_.equal_range({node, touch.object});
    return std::any_of(begin, end, [&](const auto& held) { return held.second.dot(touch.normal) > least_cosine; });
  };
  for (int i = 0; i < 3; ++i) {
    if (weights[i] > kLeastWeight && !is_held(face.m_n[i])) return false;
  }
  return true;
}

/// Adds the deepest touch in each distinct direction, of one edge's touches with one mesh.
void MeshPolicy::add_edge_touches() {
  for (auto& [key, touches] : edge_touches_) {
    const WorldMirror::Member& member = mirror_.member(BodyId{std::get<0>(key)});
    std::stable_sort(touches.begin(), touches.end(),
                     [](const EdgeTouch& a, const EdgeTouch& b) { return a.depth_at_end < b.depth_at_end; });
    for (auto touch = touches.begin(); touch != touches.end(); ++touch) {
      const bool is_known = std::any_of(touches.begin(), touch, [&](const EdgeTouch& before) {
        return before.touch.normal.dot(touch->touch.normal) > kSameNormal;
      });
      if (!is_known) touches_.add(*member.body, *touch->face, touch->weights, touch->touch);
    }
  }
}

}  // namespace softcd::bullet

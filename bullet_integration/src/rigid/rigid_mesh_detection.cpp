#include "rigid/rigid_mesh_detection.hpp"

#include <algorithm>

#include "BulletCollision/CollisionShapes/btConcaveShape.h"
#include "bodies/query_options.hpp"
#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

using Flags = btSoftBody::fCollision;

/// One node's contacts with one mesh whose normals are closer than that (8 degrees) are one: on a smooth surface a node
/// touches several triangles at once.
constexpr btScalar kSameNormal = btScalar(0.99);

/// Contacts of one node with one mesh, of which only those with a direction of their own are kept, the deepest.
class NodeTouches {
 public:
  void add(const RigidTouch& touch, btScalar depth_at_end) { touches_.emplace_back(depth_at_end, touch); }

  template <class Write>
  void flush(Write write) {
    std::stable_sort(touches_.begin(), touches_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    kept_.clear();
    for (const auto& entry : touches_) {
      const RigidTouch& touch = entry.second;
      const bool is_known = std::any_of(
          kept_.begin(), kept_.end(), [&](const btVector3& normal) { return normal.dot(touch.normal) > kSameNormal; });
      if (is_known) continue;
      kept_.push_back(touch.normal);
      write(touch);
    }
    touches_.clear();
  }

 private:
  std::vector<std::pair<btScalar, RigidTouch>> touches_;
  std::vector<btVector3> kept_;
};

/// Nodes that are kept off nearly in a touch's direction (within 26 degrees) keep off what is between them, too.
constexpr btScalar kNearlySameNormal = btScalar(0.9);

/// Share of the margin at which corners and edges of a mesh hold faces. The nodes have contacts at the whole margin:
/// on ground that is coarser than a cloth, corners are within the margin of most faces and need no contact.
constexpr btScalar kFaceMarginShare = btScalar(0.5);

/// Whether edges of faces touch edges of meshes. In classic worlds CrossingPrevention keeps them apart.
bool holds_faces(const ContactsOfKind& kind) {
  return !kind.solves_in_turns;
}

QueryOptions mesh_options(const ContactsOfKind& kind, const Settings& settings) {
  QueryOptions options = continuous_options(settings);
  options.features = {/*vertex_triangle=*/true, holds_faces(kind) || settings.edge_contacts == EdgeContacts::respond};
  return options;
}

/// Contacts at ends of edges are those of the nodes there.
bool is_inside(const Contact& contact) {
  return std::all_of(contact.weights, contact.weights + 4, [](float weight) { return weight > float(kLeastWeight); });
}

/// Weights of the face's nodes for a point on one of its edges.
btVector3 weights_on_edge(const btSoftBody::Face& face, const btSoftBody& body, const std::uint32_t* nodes,
                          const float* weights) {
  btVector3 result(0, 0, 0);
  for (int i = 0; i < 3; ++i) {
    for (int end = 0; end < 2; ++end) {
      if (face.m_n[i] == &body.m_nodes[static_cast<int>(nodes[end])]) result[i] = btScalar(weights[end]);
    }
  }
  return result;
}

/// Whether Bullet's solver would see contacts of faces and links, where it is the deformable one.
bool solves_faces(const btSoftBody& soft, const btCollisionObject& object) {
  return !has_deformable_contacts(soft) || ((soft.m_cfg.collisions & (Flags::SDF_RDN | Flags::SDF_RDF)) != 0 &&
                                            object.getInternalType() == btCollisionObject::CO_RIGID_BODY);
}

}  // namespace

RigidMeshDetection::RigidMeshDetection(const ContactsOfKind& kind, WorldMirror& mirror, const Settings& settings)
    : kind_(kind), mirror_(mirror), settings_(settings), query_(mirror.scene(), mesh_options(kind, settings)) {
  query_.set_pair_filter([this](BodyId a, BodyId b) {
    return std::binary_search(wanted_.begin(), wanted_.end(), std::pair(a.value, b.value));
  });
}

RigidMeshDetection::~RigidMeshDetection() {
  for (const auto& [key, mesh] : meshes_) {
    if (mirror_.scene().has_body(mesh.id)) mirror_.scene().remove_body(mesh.id);
  }
}

void RigidMeshDetection::follow_settings() {
  query_.set_options(mesh_options(kind_, settings_));
  touches_.forget_notes();
}

void RigidMeshDetection::synchronize_mesh(const MeshKey& key, Span<const RigidPair> pairs, btScalar time_step) {
  const auto& shape = static_cast<const btConcaveShape&>(*std::get<1>(key));
  const RigidPoses poses = poses_of(*pairs[0].object, pairs[0].shape_in_object, time_step);
  BodySettings settings;
  settings.margin = std::max(0.0F, static_cast<float>(shape.getMargin()));
  settings.self_collision = false;
  settings.features.edge_edge =
      holds_faces(kind_) || std::any_of(pairs.begin(), pairs.end(), [this](const RigidPair& pair) {
        return !mirror_.member(*pair.soft).mesh.segments.empty();
      });

  std::vector<RigidBox> boxes;
  for (const RigidPair& pair : pairs) {
    const btScalar margin = pair.soft->getCollisionShape()->getMargin() + shape.getMargin();
    boxes.push_back(box_in_shape(swept_box(*pair.soft, margin), poses));
  }
  const auto [entry, is_new] = meshes_.try_emplace(key);
  Mesh& mesh = entry->second;
  const bool has_changed = mesh.mesh.read(shape, boxes);
  mesh.pair = pairs[0];
  mesh.is_present = true;
  if (is_new) {
    mesh.id = mirror_.scene().add_body({mesh.mesh.triangles(), mesh.mesh.vertex_count(), settings});
    meshes_by_id_[mesh.id.value] = &mesh;
  } else if (has_changed) {
    mirror_.scene().update_body(mesh.id, {mesh.mesh.triangles(), mesh.mesh.vertex_count(), settings});
  } else {
    mirror_.scene().set_settings(mesh.id, settings);
  }
  if (mesh.mesh.place(poses)) mirror_.scene().set_positions(mesh.id, mesh.mesh.x_t0(), mesh.mesh.x_t1());
  for (const RigidPair& pair : pairs) {
    wanted_.emplace_back(std::minmax(mesh.id.value, mirror_.member(*pair.soft).id.value));
  }
}

void RigidMeshDetection::remove_absent_meshes() {
  for (auto entry = meshes_.begin(); entry != meshes_.end();) {
    if (std::exchange(entry->second.is_present, false)) {
      ++entry;
      continue;
    }
    mirror_.scene().remove_body(entry->second.id);
    meshes_by_id_.erase(entry->second.id.value);
    entry = meshes_.erase(entry);
  }
}

void RigidMeshDetection::find_contacts(std::vector<RigidPair> pairs, btScalar time_step) {
  touches_.forget_notes();
  // Bullet neither solves nor clears the contacts of a body that sleeps: they would pile up.
  std::erase_if(pairs, [](const RigidPair& pair) { return !pair.soft->isActive() || pair.soft->m_nodes.size() == 0; });
  for (const RigidPair& pair : pairs) {
    WorldMirror::Member& member = mirror_.require(*pair.soft, /*needs_way=*/true);
    if (holds_faces(kind_) && member.mesh.first_face_of_node.empty()) add_faces_of_nodes(member.mesh);
  }
  wanted_.clear();
  // Meshes in the order in which Bullet came upon them: addresses, which make the key, differ from run to run.
  const auto key_of = [](const RigidPair& pair) { return MeshKey(pair.object, pair.shape, pair.child); };
  for (auto begin = pairs.begin(); begin != pairs.end();) {
    const MeshKey key = key_of(*begin);
    const auto end =
        std::stable_partition(begin, pairs.end(), [&](const RigidPair& pair) { return key_of(pair) == key; });
    synchronize_mesh(key, {&*begin, static_cast<std::size_t>(end - begin)}, time_step);
    begin = end;
  }
  remove_absent_meshes();
  if (pairs.empty()) return;
  std::sort(wanted_.begin(), wanted_.end());
  find_touches();
  touches_.prepare_to_write(settings_.read_out != ReadOut::off);
  touches_.write();
}

void RigidMeshDetection::find_touches() {
  touches_.clear();
  corner_touches_.clear();
  edge_touches_.clear();
  node_normals_.clear();
  NodeTouches touches;
  btSoftBody* body = nullptr;
  btSoftBody::Node* node = nullptr;
  const auto write = [&](const RigidTouch& touch) {
    touches_.add(*body, *node, touch);
    if (query_.options().features.edge_edge) node_normals_.emplace(std::pair(node, touch.object), touch.normal);
  };
  const auto flush = [&] { touches.flush(write); };
  BodyId last_mesh;
  for (const Contact& contact : query_.detect()) {
    if (contact.kind == ContactKind::edge_edge) {
      find_edge_touch(contact);
      continue;
    }
    const btVector3 normal = to_bullet(contact.normal);
    const auto a = meshes_by_id_.find(contact.body_a.value);
    if (a != meshes_by_id_.end()) {
      find_face_touch(contact, *a->second, -normal);
      continue;
    }
    btSoftBody& soft = *mirror_.member(contact.body_a).body;
    btSoftBody::Node& soft_node = soft.m_nodes[static_cast<int>(contact.feature_a)];
    if (&soft_node != node || contact.body_b != last_mesh) {
      flush();
      body = &soft;
      node = &soft_node;
      last_mesh = contact.body_b;
    }
    if (soft_node.m_battach != 0) continue;
    if (has_deformable_contacts(soft) && (soft.m_cfg.collisions & Flags::SDF_RDN) == 0) continue;
    const Mesh& mesh = *meshes_by_id_.at(contact.body_b.value);
    const RigidTouch touch = {mesh.pair.object,
                              normal,
                              soft.getCollisionShape()->getMargin() + mesh.pair.shape->getMargin(),
                              weighted_point(mesh.mesh.x_t0(), contact.vertices + 1, contact.weights + 1, 3),
                              weighted_point(mesh.mesh.x_t1(), contact.vertices + 1, contact.weights + 1, 3),
                              contact.time_of_impact};
    const btScalar depth_at_end = depth(touch, soft_node.*kind_.ends.end, touch.object_point_t1);
    if (depth_at_end < 0) touches.add(touch, depth_at_end);
  }
  flush();
  add_corner_touches();
  add_edge_touches();
}

void RigidMeshDetection::find_face_touch(const Contact& contact, const Mesh& mesh, const btVector3& normal) {
  const WorldMirror::Member& member = mirror_.member(contact.body_b);
  btSoftBody& soft = *member.body;
  if (!has_deformable_contacts(soft) || !solves_faces(soft, *mesh.pair.object)) return;
  if (contact.feature_b >= member.mesh.face_count) return;
  btSoftBody::Face& face = soft.m_faces[static_cast<int>(contact.feature_b)];
  const btVector3 weights = triangle_weights(contact.weights);
  const bool is_tested_by_bullet = (soft.m_cfg.collisions & Flags::SDF_RDF) != 0;
  const RigidTouch touch = {mesh.pair.object,
                            normal,
                            (soft.getCollisionShape()->getMargin() + mesh.pair.shape->getMargin()) *
                                (is_tested_by_bullet ? 1 : kFaceMarginShare),
                            to_bullet(mesh.mesh.x_t0()[contact.feature_a]),
                            to_bullet(mesh.mesh.x_t1()[contact.feature_a]),
                            contact.time_of_impact};
  btVector3 end(0, 0, 0);
  for (int i = 0; i < 3; ++i) end += weights[i] * (face.m_n[i]->*kind_.ends.end);
  if (depth(touch, end, touch.object_point_t1) >= 0) return;
  if (is_tested_by_bullet) {
    touches_.add(soft, face, weights, touch);
  } else {
    corner_touches_.push_back({&soft, &face, weights, touch});
  }
}

void RigidMeshDetection::add_corner_touches() {
  for (const auto& [soft, face, weights, touch] : corner_touches_) {
    if (!are_held(*face, weights, touch, kNearlySameNormal)) touches_.add(*soft, *face, weights, touch);
  }
}

void RigidMeshDetection::find_edge_touch(const Contact& contact) {
  const auto a = meshes_by_id_.find(contact.body_a.value);
  const bool is_swapped = a != meshes_by_id_.end();
  const Mesh& mesh = is_swapped ? *a->second : *meshes_by_id_.at(contact.body_b.value);
  const WorldMirror::Member& member = mirror_.member(is_swapped ? contact.body_b : contact.body_a);
  const bool is_link = !member.mesh.segments.empty();
  const bool is_answered = is_link ? settings_.edge_contacts == EdgeContacts::respond
                                   : holds_faces(kind_) && has_deformable_contacts(*member.body);
  if (!is_answered) return;
  if (!is_inside(contact) || !solves_faces(*member.body, *mesh.pair.object)) return;
  const std::uint32_t edge = is_swapped ? contact.feature_b : contact.feature_a;
  const int own = is_swapped ? 2 : 0;
  const int other = 2 - own;
  const btVector3 normal = to_bullet(contact.normal);
  const RigidTouch touch = {
      mesh.pair.object,
      is_swapped ? -normal : normal,
      (member.body->getCollisionShape()->getMargin() + mesh.pair.shape->getMargin()) * (is_link ? 1 : kFaceMarginShare),
      weighted_point(mesh.mesh.x_t0(), contact.vertices + other, contact.weights + other, 2),
      weighted_point(mesh.mesh.x_t1(), contact.vertices + other, contact.weights + other, 2),
      contact.time_of_impact};
  btSoftBody::Face& face = member.face_at_edge(edge, contact.vertices + own);
  const btVector3 weights = weights_on_edge(face, *member.body, contact.vertices + own, contact.weights + own);
  btVector3 end(0, 0, 0);
  for (int i = 0; i < 3; ++i) {
    if (weights[i] > 0) end += weights[i] * (face.m_n[i]->*kind_.ends.end);
  }
  const btScalar depth_at_end = depth(touch, end, touch.object_point_t1);
  const btScalar least_cosine = is_link ? kSameNormal : kNearlySameNormal;
  if (depth_at_end < 0 && !are_held(face, weights, touch, least_cosine)) {
    edge_touches_[{member.id.value, edge, mesh.id.value}].push_back({&face, touch, weights, depth_at_end});
  }
}

/// Whether all nodes that have a weight have contacts that hold them off the object in that direction, as on a flat
/// surface, whose triangles have corners and edges, too.
bool RigidMeshDetection::are_held(const btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch,
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

/// Of one edge with one mesh only those with a direction of their own, the deepest.
void RigidMeshDetection::add_edge_touches() {
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

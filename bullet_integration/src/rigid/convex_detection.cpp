#include "rigid/convex_detection.hpp"

#include <algorithm>
#include <iterator>

#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "LinearMath/btAabbUtil2.h"
#include "LinearMath/btQuickprof.h"
#include "bodies/query_options.hpp"
#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

/// Contacts at ends of edges, and at borders of faces, are those of what is there.
constexpr auto kInside = static_cast<float>(kLeastWeight);

QueryOptions convex_options(const Settings& settings) {
  QueryOptions options = continuous_options(settings);
  options.features = {/*vertex_triangle=*/true, /*edge_edge=*/true};
  return options;
}

bool wants_faces(const btSoftBody& soft, const btCollisionObject& object) {
  if (!has_deformable_contacts(soft)) return true;
  switch (object.getInternalType()) {
    case btCollisionObject::CO_RIGID_BODY:
      return (soft.m_cfg.collisions & btSoftBody::fCollision::SDF_RDF) != 0;
    case btCollisionObject::CO_FEATHERSTONE_LINK:
      return (soft.m_cfg.collisions & btSoftBody::fCollision::SDF_MDF) != 0;
    default:
      return false;
  }
}

/// What is deeper in the shape than that, or on the other side of it, is near for another reason.
bool can_touch(const ConvexCore& core, const RigidTouch& touch) {
  const btVector3 point = lerp(touch.object_point_t0, touch.object_point_t1, btScalar(touch.time_of_impact));
  return core.is_farthest(point, touch.normal, double(touch.time_of_impact));
}

}  // namespace

ConvexDetection::ConvexDetection(const NodeEnds& ends, WorldMirror& mirror, const Settings& settings)
    : ends_(ends), mirror_(mirror), settings_(settings), query_(mirror.scene(), convex_options(settings)) {
  query_.set_pair_filter([this](BodyId a, BodyId b) {
    return std::binary_search(wanted_.begin(), wanted_.end(), std::pair(a.value, b.value));
  });
}

ConvexDetection::~ConvexDetection() {
  for (const auto& [key, shape] : shapes_) {
    if (mirror_.scene().has_body(shape.id)) mirror_.scene().remove_body(shape.id);
  }
}

void ConvexDetection::follow_settings() {
  query_.set_options(convex_options(settings_));
  touches_.forget_notes();
  if (settings_.convex_shapes == ConvexShapes::nodes) remove_absent_shapes();
}

void ConvexDetection::add_parts(const btCollisionObject& object, const btCollisionShape& shape,
                                const btTransform& place, std::vector<Part>& parts) {
  if (shape.isCompound()) {
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i) {
      add_parts(object, *compound.getChildShape(i), place * compound.getChildTransform(i), parts);
    }
  } else if (shape.isConvex()) {
    const PartKey key(&object, static_cast<int>(parts.size()));
    parts.push_back({key, static_cast<const btConvexShape*>(&shape), place});
  }
}

/// With all the soft bodies that it may touch.
void ConvexDetection::synchronize_object(Span<const RigidPair> pairs, btScalar time_step) {
  const btCollisionObject& object = *pairs[0].object;
  std::vector<Part> parts;
  add_parts(object, *object.getCollisionShape(), btTransform::getIdentity(), parts);
  std::vector<RigidBox> boxes;
  for (const RigidPair& pair : pairs) {
    boxes.push_back(swept_box(*pair.soft, pair.soft->getCollisionShape()->getMargin()));
  }
  for (const Part& part : parts) {
    const RigidPoses poses = poses_of(object, part.shape_in_object, time_step);
    btVector3 low;
    btVector3 high;
    part.shape->getAabb(btTransform::getIdentity(), low, high);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const RigidBox box = box_in_shape(boxes[i], poses);
      if (!TestAabbAgainstAabb2(low, high, box.low, box.high)) continue;
      const Shape& shape = synchronize(part, poses);
      wanted_.emplace_back(std::minmax(shape.id.value, mirror_.member(*pairs[i].soft).id.value));
    }
  }
}

ConvexDetection::Shape& ConvexDetection::synchronize(const Part& part, const RigidPoses& poses) {
  const auto [entry, is_new] = shapes_.try_emplace(part.key);
  Shape& shape = entry->second;
  if (std::exchange(shape.is_present, true)) return shape;
  const bool has_changed = shape.core.read(*part.shape);
  shape.object = part.key.first;
  shape.margin = part.shape->getMarginNonVirtual();
  BodySettings settings;
  settings.margin = std::max(0.0F, static_cast<float>(shape.margin));
  settings.features = {/*vertex_triangle=*/true, /*edge_edge=*/true};
  settings.self_collision = false;
  if (is_new) {
    shape.id = mirror_.scene().add_body({shape.core.triangles(), shape.core.vertex_count(), settings});
    shapes_by_id_[shape.id.value] = &shape;
  } else if (has_changed) {
    mirror_.scene().update_body(shape.id, {shape.core.triangles(), shape.core.vertex_count(), settings});
  } else {
    mirror_.scene().set_settings(shape.id, settings);
  }
  if (shape.core.place(poses)) mirror_.scene().set_positions(shape.id, shape.core.x_t0(), shape.core.x_t1());
  return shape;
}

void ConvexDetection::remove_absent_shapes() {
  for (auto entry = shapes_.begin(); entry != shapes_.end();) {
    if (std::exchange(entry->second.is_present, false)) {
      ++entry;
      continue;
    }
    mirror_.scene().remove_body(entry->second.id);
    shapes_by_id_.erase(entry->second.id.value);
    entry = shapes_.erase(entry);
  }
}

void ConvexDetection::find_contacts(std::vector<RigidPair> pairs, btScalar time_step) {
  BT_PROFILE("softcd convex shapes");
  touches_.forget_notes();
  meetings_.clear();
  // Bullet neither solves nor clears the contacts of a body that sleeps: they would pile up.
  std::erase_if(pairs, [](const RigidPair& pair) { return !pair.soft->isActive() || pair.soft->m_faces.size() == 0; });
  wanted_.clear();
  native_.clear();
  std::set<const btSoftBody*> read;
  for (const RigidPair& pair : pairs) {
    if (read.insert(pair.soft).second) native_.read(*pair.soft);
    WorldMirror::Member& member = mirror_.require(*pair.soft, /*needs_way=*/true);
    if (member.mesh.first_face_of_node.empty()) add_faces_of_nodes(member.mesh);
  }
  // Objects in the order in which Bullet came upon them: addresses differ from run to run.
  for (auto begin = pairs.begin(); begin != pairs.end();) {
    const btCollisionObject* const object = begin->object;
    const auto end =
        std::stable_partition(begin, pairs.end(), [&](const RigidPair& pair) { return pair.object == object; });
    synchronize_object({&*begin, static_cast<std::size_t>(end - begin)}, time_step);
    begin = end;
  }
  remove_absent_shapes();
  if (wanted_.empty()) return;
  std::sort(wanted_.begin(), wanted_.end());
  find_touches();
  touches_.prepare_to_write(settings_.read_out != ReadOut::off);
  native_.remove_doubted();
  touches_.write();
}

void ConvexDetection::find_touches() {
  touches_.clear();
  known_.clear();
  for (const Contact& contact : query_.detect()) {
    const auto a = shapes_by_id_.find(contact.body_a.value);
    if (contact.kind == ContactKind::edge_edge) {
      find_edge(contact, a != shapes_by_id_.end() ? a->second : nullptr);
    } else if (a != shapes_by_id_.end()) {
      find_corner(contact, *a->second);
    } else {
      find_node(contact, *shapes_by_id_.at(contact.body_b.value));
    }
  }
}

/// The shape is on side a of the contact, or on b.
RigidTouch ConvexDetection::touch_of(const Contact& contact, const Shape& shape, const btSoftBody& soft,
                                     bool is_a) const {
  const int count_a = contact.kind == ContactKind::edge_edge ? 2 : 1;
  const int first = is_a ? 0 : count_a;
  const int count = is_a ? count_a : 4 - count_a;
  const btVector3 normal = to_bullet(contact.normal);
  return {shape.object,
          is_a ? -normal : normal,
          soft.getCollisionShape()->getMargin() + shape.margin,
          weighted_point(shape.core.x_t0(), contact.vertices + first, contact.weights + first, count),
          weighted_point(shape.core.x_t1(), contact.vertices + first, contact.weights + first, count),
          contact.time_of_impact};
}

void ConvexDetection::find_corner(const Contact& contact, const Shape& shape) {
  const WorldMirror::Member& member = mirror_.member(contact.body_b);
  btSoftBody& soft = *member.body;
  if (!wants_faces(soft, *shape.object) || contact.feature_b >= member.mesh.face_count) return;
  btSoftBody::Face& face = soft.m_faces[static_cast<int>(contact.feature_b)];
  const btVector3 weights = triangle_weights(contact.weights);
  // At a border it comes up for the faces on both sides.
  const void* nodes[3];
  for (int i = 0; i < 3; ++i) nodes[i] = contact.weights[1 + i] > kInside ? face.m_n[i] : nullptr;
  std::sort(nodes, nodes + 3, std::less<>());
  if (!known_.emplace(shape.id.value, contact.feature_a, nodes[0], nodes[1], nodes[2]).second) return;
  const RigidTouch touch = touch_of(contact, shape, soft, /*is_a=*/true);
  add_face_touch(shape, soft, face, weights, touch);
}

/// `a` is null where the shape is on side b.
void ConvexDetection::find_edge(const Contact& contact, const Shape* a) {
  const Shape& shape = a != nullptr ? *a : *shapes_by_id_.at(contact.body_b.value);
  const WorldMirror::Member& member = mirror_.member(a != nullptr ? contact.body_b : contact.body_a);
  btSoftBody& soft = *member.body;
  const bool is_inside = std::all_of(contact.weights, contact.weights + 4, [](float w) { return w > kInside; });
  const std::uint32_t* const rigid = contact.vertices + (a != nullptr ? 0 : 2);
  if (!is_inside || !wants_faces(soft, *shape.object) || !shape.core.is_edge(rigid[0], rigid[1])) return;
  const int first = a != nullptr ? 2 : 0;
  const std::uint32_t face_index = face_at_edge(member.mesh, contact.vertices[first], contact.vertices[first + 1]);
  if (face_index == kNoIndex) return;
  btSoftBody::Face& face = soft.m_faces[static_cast<int>(face_index)];
  btVector3 weights(0, 0, 0);
  for (int i = 0; i < 3; ++i) {
    for (int end = 0; end < 2; ++end) {
      const auto node = static_cast<int>(contact.vertices[first + end]);
      if (face.m_n[i] == &soft.m_nodes[node]) weights[i] = btScalar(contact.weights[first + end]);
    }
  }
  const RigidTouch touch = touch_of(contact, shape, soft, a != nullptr);
  add_face_touch(shape, soft, face, weights, touch);
}

void ConvexDetection::add_face_touch(const Shape& shape, btSoftBody& soft, btSoftBody::Face& face,
                                     const btVector3& weights, RigidTouch touch) {
  btVector3 start(0, 0, 0);
  btVector3 end(0, 0, 0);
  for (int i = 0; i < 3; ++i) {
    start += weights[i] * (face.m_n[i]->*ends_.start);
    end += weights[i] * (face.m_n[i]->*ends_.end);
  }
  // Of what is in each other already, as Bullet's solver left it, the way out is the shorter one.
  if (!(touch.time_of_impact > 0) && shape.core.is_pierced(start, touch.normal)) touch.normal = -touch.normal;
  if (depth(touch, end, touch.object_point_t1) >= 0 || !can_touch(shape.core, touch)) return;
  if (native_.hold(face, weights, touch)) return;
  touches_.add(soft, face, weights, touch);
  meetings_.emplace_back(&soft, touch.object);
}

/// Bullet's own test looks at where nodes are, not at their way.
void ConvexDetection::find_node(const Contact& contact, const Shape& shape) {
  btSoftBody& soft = *mirror_.member(contact.body_a).body;
  btSoftBody::Node& node = soft.m_nodes[static_cast<int>(contact.feature_a)];
  if (node.m_battach != 0) return;
  if (has_deformable_contacts(soft) && (soft.m_cfg.collisions & btSoftBody::fCollision::SDF_RDN) == 0) return;
  const RigidTouch touch = touch_of(contact, shape, soft, /*is_a=*/false);
  if (depth(touch, node.*ends_.end, touch.object_point_t1) >= 0 || !can_touch(shape.core, touch)) return;
  if (native_.hold(node, touch)) return;
  // At edges it comes up for the triangles on both sides.
  if (!known_.emplace(shape.id.value, kNoIndex, &node, nullptr, nullptr).second) return;
  native_.doubt(node, *shape.object);
  touches_.add(soft, node, touch);
  meetings_.emplace_back(&soft, touch.object);
}

}  // namespace softcd::bullet

#include "rigid/convex_detection.hpp"

#include <algorithm>
#include <iterator>

#include "LinearMath/btAabbUtil2.h"
#include "LinearMath/btQuickprof.h"
#include "bodies/query_options.hpp"
#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

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

/// Returns whether the object can be touched there: its point has to be the farthest along the normal. Points deeper in
/// the shape, or on its other side, are near for another reason.
bool can_touch(const ConvexCore& core, const RigidTouch& touch) {
  const btVector3 point = lerp(touch.object_point_t0, touch.object_point_t1, btScalar(touch.time_of_impact));
  return core.is_farthest(point, touch.normal, double(touch.time_of_impact));
}

}  // namespace

ConvexDetection::ConvexDetection(const NodeEnds& ends, WorldMirror& mirror, const Settings& settings)
    : ends_(ends),
      mirror_(mirror),
      settings_(settings),
      query_(mirror.scene(), convex_options(settings)),
      shapes_(mirror) {
  query_.set_pair_filter([this](BodyId a, BodyId b) { return shapes_.wants(a, b); });
}

void ConvexDetection::follow_settings() {
  query_.set_options(convex_options(settings_));
  touches_.forget_notes();
  if (settings_.convex_shapes != ConvexShapes::nodes) return;
  shapes_.begin_step();
  shapes_.end_step();
}

/// Puts the object's shapes into the scene, for all soft bodies that it may touch.
void ConvexDetection::require_shapes(Span<const RigidPair> pairs, btScalar time_step) {
  const btCollisionObject& object = *pairs[0].object;
  std::vector<RigidBox> boxes;
  for (const RigidPair& pair : pairs) {
    boxes.push_back(swept_box(*pair.soft, pair.soft->getCollisionShape()->getMargin()));
  }
  int number = 0;
  const auto require = [&](const btCollisionShape& simple, const btTransform& place) {
    if (!simple.isConvex()) return false;
    const auto& shape = static_cast<const btConvexShape&>(simple);
    const PartKey key(BodyKey(object), number++);
    const RigidPoses poses = poses_of(object, place, time_step);
    btVector3 low;
    btVector3 high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const RigidBox box = box_in_shape(boxes[i], poses);
      if (!TestAabbAgainstAabb2(low, high, box.low, box.high)) continue;
      const auto read = [&](ConvexCore& core) { return core.read(shape); };
      shapes_.want(shapes_.require(key, object, shape.getMarginNonVirtual(), /*has_edges=*/true, poses, read),
                   *pairs[i].soft);
    }
    return false;
  };
  any_simple_shape(*object.getCollisionShape(), btTransform::getIdentity(), require);
}

void ConvexDetection::find_contacts(std::vector<RigidPair> pairs, btScalar time_step) {
  BT_PROFILE("softcd convex shapes");
  touches_.forget_notes();
  meetings_.clear();
  // Skips sleeping bodies: Bullet neither solves nor clears their contacts, which would pile up.
  std::erase_if(pairs, [](const RigidPair& pair) { return !pair.soft->isActive() || pair.soft->m_faces.size() == 0; });
  shapes_.begin_step();
  native_.clear();
  std::set<const btSoftBody*> read;
  for (const RigidPair& pair : pairs) {
    if (read.insert(pair.soft).second) native_.read(*pair.soft);
    mirror_.require(*pair.soft, /*needs_way=*/true);
  }
  // Takes objects in the order in which Bullet dispatched them, because addresses differ from run to run.
  for (auto begin = pairs.begin(); begin != pairs.end();) {
    const btCollisionObject* const object = begin->object;
    const auto end =
        std::stable_partition(begin, pairs.end(), [&](const RigidPair& pair) { return pair.object == object; });
    require_shapes({&*begin, static_cast<std::size_t>(end - begin)}, time_step);
    begin = end;
  }
  if (!shapes_.end_step()) return;
  find_touches();
  touches_.prepare_to_write(settings_.read_out != ReadOut::off);
  native_.remove_doubted();
  touches_.write();
}

void ConvexDetection::find_touches() {
  touches_.clear();
  known_.clear();
  shapes_.for_each_contact(query_.detect(), [this](const ShapeContact& found) {
    if (found.contact.kind == ContactKind::edge_edge) {
      find_edge(found);
    } else if (found.is_part_a) {
      find_corner(found);
    } else {
      find_node(found);
    }
  });
}

void ConvexDetection::find_corner(const ShapeContact& found) {
  const Contact& contact = found.contact;
  btSoftBody& soft = *found.soft.body;
  if (!wants_faces(soft, *found.part.object) || contact.feature_b >= found.soft.mesh.face_count) return;
  btSoftBody::Face& face = soft.m_faces[static_cast<int>(contact.feature_b)];
  // A corner at a border has a contact with each of the faces there.
  const void* nodes[3];
  for (int i = 0; i < 3; ++i) nodes[i] = contact.weights[1 + i] > float(kLeastWeight) ? face.m_n[i] : nullptr;
  std::sort(nodes, nodes + 3, std::less<>());
  if (!known_.emplace(found.part.id.value, contact.feature_a, nodes[0], nodes[1], nodes[2]).second) return;
  add_face_touch(found, face, triangle_weights(contact.weights));
}

void ConvexDetection::find_edge(const ShapeContact& found) {
  const Contact& contact = found.contact;
  btSoftBody& soft = *found.soft.body;
  const std::uint32_t* const rigid = contact.vertices + found.first_of_part();
  if (!found.is_inside_edges() || !wants_faces(soft, *found.part.object) ||
      !found.part.shape.is_edge(rigid[0], rigid[1]))
    return;
  const std::uint32_t* const nodes = contact.vertices + found.first_of_soft();
  const std::uint32_t face_index = face_at_edge(found.soft.mesh, nodes[0], nodes[1]);
  if (face_index == kNoIndex) return;
  btSoftBody::Face& face = soft.m_faces[static_cast<int>(face_index)];
  add_face_touch(found, face, weights_on_edge(face, soft, nodes, contact.weights + found.first_of_soft()));
}

void ConvexDetection::add_face_touch(const ShapeContact& found, btSoftBody::Face& face, const btVector3& weights) {
  const ConvexCore& core = found.part.shape;
  RigidTouch touch = found.touch(found.margin());
  // Bodies that already intersect, because Bullet's solver left them so, part along the shorter way.
  const bool may_be_inside = !(touch.time_of_impact > 0);
  if (may_be_inside && core.is_pierced(point_on(face, weights, ends_.start), touch.normal))
    touch.normal = -touch.normal;
  if (depth(touch, point_on(face, weights, ends_.end), touch.object_point_t1) >= 0 || !can_touch(core, touch)) return;
  if (native_.hold(face, weights, touch)) return;
  touches_.add(*found.soft.body, face, weights, touch);
  meetings_.emplace_back(found.soft.body, touch.object);
}

/// Finds nodes that Bullet's own test misses, as it uses their positions at one time and not their paths.
void ConvexDetection::find_node(const ShapeContact& found) {
  btSoftBody& soft = *found.soft.body;
  btSoftBody::Node& node = soft.m_nodes[static_cast<int>(found.contact.feature_a)];
  if (!takes_node_contacts(soft, node)) return;
  const RigidTouch touch = found.touch(found.margin());
  if (depth(touch, node.*ends_.end, touch.object_point_t1) >= 0 || !can_touch(found.part.shape, touch)) return;
  if (native_.hold(node, touch)) return;
  // A node at an edge has a contact with each of the triangles there.
  if (!known_.emplace(found.part.id.value, kNoIndex, &node, nullptr, nullptr).second) return;
  native_.doubt(node, *found.part.object);
  touches_.add(soft, node, touch);
  meetings_.emplace_back(&soft, touch.object);
}

}  // namespace softcd::bullet

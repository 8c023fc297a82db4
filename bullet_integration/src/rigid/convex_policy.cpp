#include "rigid/convex_policy.hpp"

#include <algorithm>

#include "bodies/query_options.hpp"
#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

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

QueryOptions ConvexPolicy::options(const ContactsOfKind& /*kind*/, const Settings& settings) {
  QueryOptions options = continuous_options(settings);
  options.features = {/*vertex_triangle=*/true, /*edge_edge=*/true};
  return options;
}

void ConvexPolicy::require(const RigidKey& key, Span<const RigidPair> pairs, btScalar time_step,
                           const ReadsWhole& /*reads_whole*/, RigidParts<ConvexCore>& parts) {
  const btCollisionObject& object = *pairs[0].object;
  std::vector<Bounds> boxes;
  for (const RigidPair& pair : pairs) {
    boxes.push_back(swept_box(*pair.soft, margin_of(*pair.soft)));
  }
  RigidKey part_key = key;
  int number = 0;
  const auto require = [&](const btCollisionShape& simple, const btTransform& place) {
    if (!simple.isConvex()) return false;
    const auto& shape = static_cast<const btConvexShape&>(simple);
    std::get<2>(part_key) = number++;
    const RigidPoses poses = poses_of(object, place, time_step);
    const Bounds bounds = bounds_of(shape, btTransform::getIdentity());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (!bounds.overlaps(box_in_shape(boxes[i], poses))) continue;
      const auto read = [&](ConvexCore& core) { return core.read(shape); };
      const auto& part = parts.require(part_key, object, shape.getMarginNonVirtual(), /*has_edges=*/true, poses, read);
      parts.want(part, *pairs[i].soft, mirror_.member(*pairs[i].soft).id);
    }
    return false;
  };
  any_simple_shape(*object.getCollisionShape(), btTransform::getIdentity(), require);
}

void ConvexPolicy::begin_contacts(Span<const NearRigidPart> near_parts, const TangledNodes* /*released*/) {
  known_.clear();
  meetings_.clear();
  native_.clear();
  std::set<const btSoftBody*> read;
  for (const NearRigidPart& each : near_parts) {
    if (read.insert(each.soft).second) native_.read(*each.soft);
  }
}

void ConvexPolicy::take(const ShapeContact& found) {
  if (found.contact.kind == ContactKind::edge_edge) {
    find_edge(found);
  } else if (found.is_part_a) {
    find_corner(found);
  } else {
    find_node(found);
  }
}

void ConvexPolicy::find_corner(const ShapeContact& found) {
  const Contact& contact = found.contact;
  btSoftBody& soft = *found.soft.body;
  if (!wants_faces(soft, *found.part.object) || contact.feature_b >= found.soft.mesh.face_count) return;
  btSoftBody::Face& face = found.soft.face(contact.feature_b);
  // A corner at a border has a contact with each of the faces there.
  const void* nodes[3];
  for (int i = 0; i < 3; ++i) nodes[i] = contact.weights[1 + i] > float(kLeastWeight) ? face.m_n[i] : nullptr;
  std::sort(nodes, nodes + 3, std::less<>());
  if (!known_.emplace(found.part.id.value, contact.feature_a, nodes[0], nodes[1], nodes[2]).second) return;
  add_face_touch(found, face, triangle_weights(contact.weights));
}

void ConvexPolicy::find_edge(const ShapeContact& found) {
  const Contact& contact = found.contact;
  btSoftBody& soft = *found.soft.body;
  const std::uint32_t* const rigid = contact.vertices + found.first_of_part();
  if (!found.is_inside_edges() || !wants_faces(soft, *found.part.object) ||
      !found.part.shape.is_edge(rigid[0], rigid[1]))
    return;
  const std::uint32_t* const nodes = contact.vertices + found.first_of_soft();
  const std::uint32_t face_index = face_at_edge(found.soft.mesh, nodes[0], nodes[1]);
  if (face_index == kNoIndex) return;
  btSoftBody::Face& face = found.soft.face(face_index);
  add_face_touch(found, face, weights_on_edge(face, soft, nodes, contact.weights + found.first_of_soft()));
}

void ConvexPolicy::add_face_touch(const ShapeContact& found, btSoftBody::Face& face, const btVector3& weights) {
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
void ConvexPolicy::find_node(const ShapeContact& found) {
  btSoftBody& soft = *found.soft.body;
  btSoftBody::Node& node = found.soft.node(found.contact.feature_a);
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

#include "questions/contact_test.hpp"

#include <algorithm>
#include <utility>

#include "BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h"
#include "BulletCollision/CollisionShapes/btConcaveShape.h"
#include "BulletCollision/NarrowPhaseCollision/btManifoldPoint.h"
#include "bodies/vectors.hpp"
#include "softcd/bullet/world_probe.hpp"

namespace softcd::bullet {
namespace {

using ContactCallback = btCollisionWorld::ContactResultCallback;

/// Overlaps nothing.
const Bounds kNowhere = {btVector3(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT),
                         -btVector3(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT)};

/// Returns the box of the nodes' present positions, or of the shape, enlarged by the margin and `more`.
Bounds box_of(btCollisionObject& object, btScalar more) {
  const btSoftBody* const soft = btSoftBody::upcast(&object);
  if (soft == nullptr) return bounds_of(*object.getCollisionShape(), object.getWorldTransform()).grown(more);
  if (soft->m_nodes.size() == 0) return kNowhere;
  return bounds_of(*soft, {&btSoftBody::Node::m_x}).grown(more + soft->getCollisionShape()->getMargin());
}

/// One side of a contact as reported to a callback.
struct ReportedSide {
  btCollisionObject* object;
  int part, index;
  Vec3d point;
};

/// Reports a contact to the callback. `distance` is that between the points at the margins; the normal points towards
/// `a`.
void tell(const ReportedSide& a, const ReportedSide& b, Vec3d normal, double distance, ContactCallback& callback) {
  const btVector3 on_a = to_bullet(a.point);
  const btVector3 on_b = to_bullet(b.point);
  btManifoldPoint point(a.object->getWorldTransform().invXform(on_a), b.object->getWorldTransform().invXform(on_b),
                        to_bullet(normal), btScalar(distance));
  point.m_positionWorldOnA = on_a;
  point.m_positionWorldOnB = on_b;
  point.m_partId0 = a.part;
  point.m_index0 = a.index;
  point.m_partId1 = b.part;
  point.m_index1 = b.index;
  const auto wrapper = [](const ReportedSide& side) {
    return btCollisionObjectWrapper(nullptr, side.object->getCollisionShape(), side.object,
                                    side.object->getWorldTransform(), -1, -1);
  };
  const btCollisionObjectWrapper wrapped_a = wrapper(a);
  const btCollisionObjectWrapper wrapped_b = wrapper(b);
  callback.addSingleResult(point, &wrapped_a, a.part, a.index, &wrapped_b, b.part, b.index);
}

/// A body of the scene: a soft body, or one of the simple shapes of a rigid object.
struct Part {
  BodyId id;
  btCollisionObject* object;
  double margin;
  const WorldMirror::Member* soft = nullptr;  ///< null for a rigid part
  const RigidShape* rigid = nullptr;          ///< null for a soft body
  const ConvexCore* core = nullptr;           ///< null unless `rigid` is convex

  Vec3d vertex(std::uint32_t v) const { return soft != nullptr ? soft->place(v, kPresentEnds.end) : rigid->x_t0()[v]; }
  ConvexCore::Depth depth_of(Vec3d point) const {
    return core != nullptr ? core->depth_of(point) : ConvexCore::Depth();
  }
  /// Returns whether these vertices are joined by an edge, not by a diagonal of a face of a core.
  bool is_edge(const std::uint32_t* vertices) const {
    return core == nullptr || core->is_edge(vertices[0], vertices[1]);
  }
};

class ContactTest {
 public:
  ContactTest(WorldMirror& bodies, btCollisionObject& object, ContactCallback& callback)
      : bodies_(bodies), object_(object), callback_(callback), threshold_(callback.m_closestDistanceThreshold) {
    bodies.rigid().cores.begin_step();
    bodies.rigid().meshes.begin_step();
  }
  ~ContactTest() {
    bodies_.rigid().cores.clear();
    bodies_.rigid().meshes.clear();
  }
  ContactTest(const ContactTest&) = delete;
  ContactTest& operator=(const ContactTest&) = delete;

  void run(const std::vector<btCollisionObject*>& others);

 private:
  void take(btCollisionObject& object, const Bounds& box);
  void take(btSoftBody& soft);
  btScalar margin_in_scene(const btCollisionObject& object, btScalar margin) const;
  std::vector<BodyPair> pairs() const;
  const Part& part(BodyId id) const;
  void report(const Contact& contact);
  void report_nodes_inside(const Part& soft, const Part& rigid);
  void tell_in_order(const ReportedSide& a, const ReportedSide& b, Vec3d normal, double distance);

  WorldMirror& bodies_;
  btCollisionObject& object_;
  ContactCallback& callback_;
  btScalar threshold_;
  bool is_with_itself_ = false;
  std::vector<Part> parts_;  ///< parts of `object_` come first
};

void ContactTest::run(const std::vector<btCollisionObject*>& others) {
  const btScalar more = btMax(threshold_, btScalar(0));
  const Bounds box = box_of(object_, more);
  Bounds all = kNowhere;
  std::vector<btCollisionObject*> nearby;
  for (btCollisionObject* other : others) {
    const Bounds other_box = box_of(*other, more);
    if (!box.overlaps(other_box)) continue;
    nearby.push_back(other);
    all.add(other_box);
  }
  if (nearby.empty()) return;
  is_with_itself_ = nearby.front() == &object_;
  take(object_, all);
  for (btCollisionObject* other : nearby) {
    if (other != &object_) take(*other, box);
  }
  Query query(bodies_.scene());
  query.set_only_pairs(pairs());
  for (const Contact& contact : query.detect()) report(contact);
  for (const Part& soft : parts_) {
    for (const Part& rigid : parts_) {
      if (soft.soft != nullptr && rigid.core != nullptr) report_nodes_inside(soft, rigid);
    }
  }
}

/// Puts the object into the scene: of meshes the triangles that `box` overlaps.
void ContactTest::take(btCollisionObject& object, const Bounds& box) {
  if (btSoftBody* const soft = btSoftBody::upcast(&object)) {
    if (soft->m_nodes.size() > 0) take(*soft);
    return;
  }
  RigidMirror& rigid = bodies_.rigid();
  int number = 0;
  const auto add = [&](const btCollisionShape& shape, const btTransform& place) {
    const RigidKey key(BodyKey(object), nullptr, number++, 0);
    const RigidPoses poses = {place, place};
    if (shape.isConvex()) {
      const auto& convex = static_cast<const btConvexShape&>(shape);
      const btScalar margin = convex.getMarginNonVirtual();
      const auto& part = rigid.cores.require(key, object, margin_in_scene(object, margin), /*has_edges=*/true, poses,
                                             [&](ConvexCore& core) { return core.read(convex); });
      parts_.push_back({part.id, &object, double(margin), nullptr, &part.shape, &part.shape});
    } else if (shape.isConcave() && shape.getShapeType() != STATIC_PLANE_PROXYTYPE) {
      const auto& concave = static_cast<const btConcaveShape&>(shape);
      const btScalar margin = concave.getMargin();
      const std::vector<Bounds> boxes = {box_in_shape(box.grown(margin), poses)};
      const auto& part = rigid.meshes.require(key, object, margin_in_scene(object, margin), /*has_edges=*/true, poses,
                                              [&](RigidMesh& mesh) { return mesh.read(concave, boxes); });
      parts_.push_back({part.id, &object, double(margin), nullptr, &part.shape});
    }
    return false;
  };
  any_simple_shape(*object.getCollisionShape(), object.getWorldTransform(), add);
}

void ContactTest::take(btSoftBody& soft) {
  const WorldMirror::Member& member = bodies_.require(soft, /*needs_way=*/false);
  const btScalar margin = soft.getCollisionShape()->getMargin();
  BodySettings settings;
  settings.margin = static_cast<float>(margin_in_scene(soft, margin));
  settings.features = {/*vertex_triangle=*/true, /*edge_edge=*/true};
  settings.self_collision = is_with_itself_;
  bodies_.scene().set_settings(member.id, settings);
  parts_.push_back({member.id, &soft, double(margin), &member});
}

/// Adds the threshold to the margin of one side only.
btScalar ContactTest::margin_in_scene(const btCollisionObject& object, btScalar margin) const {
  const btScalar share = is_with_itself_ ? btScalar(0.5) : btScalar(&object == &object_ ? 1 : 0);
  return btMax(btScalar(0), margin) + share * btMax(btScalar(0), threshold_);
}

std::vector<BodyPair> ContactTest::pairs() const {
  std::vector<BodyPair> pairs;
  for (const Part& a : parts_) {
    for (const Part& b : parts_) {
      const bool is_asked = is_with_itself_ || (a.object == &object_ && b.object != &object_);
      if (is_asked) pairs.push_back({a.id, b.id});
    }
  }
  // An empty list would mean all pairs.
  if (pairs.empty()) pairs.push_back({BodyId(), BodyId()});
  return pairs;
}

const Part& ContactTest::part(BodyId id) const {
  return *std::find_if(parts_.begin(), parts_.end(), [id](const Part& part) { return part.id == id; });
}

/// Returns one side of the contact, with its vertices from `begin` to `end`, for a callback.
ReportedSide reported_side(const Contact& contact, const Part& part, int begin, int end) {
  const bool is_edges = contact.kind == ContactKind::edge_edge;
  ReportedSide told = {part.object, -1, -1, {0, 0, 0}};
  for (int i = begin; i < end; ++i) {
    told.point = told.point + double(contact.weights[i]) * part.vertex(contact.vertices[i]);
  }
  if (part.soft == nullptr) return told;
  const std::uint32_t feature = begin == 0 ? contact.feature_a : contact.feature_b;
  told.part = is_edges ? kEdgePart : (begin == 0 ? kNodePart : kFacePart);
  told.index = static_cast<int>(feature);
  // Triangles after the faces represent single nodes.
  if (told.part == kFacePart && feature >= part.soft->mesh.face_count) {
    told.part = kNodePart;
    told.index = static_cast<int>(contact.vertices[1]);
  }
  return told;
}

void ContactTest::report(const Contact& contact) {
  const Part& a = part(contact.body_a);
  const Part& b = part(contact.body_b);
  const double distance = double(contact.distance) - a.margin - b.margin;
  if (!(distance <= double(threshold_))) return;
  const bool is_edges = contact.kind == ContactKind::edge_edge;
  const auto& v = contact.vertices;
  if (is_edges && !(a.is_edge(v) && b.is_edge(v + 2))) return;
  // report_nodes_inside() reports nodes inside a core, with the nearest face.
  if (!is_edges && b.depth_of(a.vertex(v[0])).is_inside) return;
  const int middle = is_edges ? 2 : 1;
  tell_in_order(reported_side(contact, a, 0, middle), reported_side(contact, b, middle, 4),
                vec3_cast<double>(contact.normal), distance);
}

void ContactTest::report_nodes_inside(const Part& soft, const Part& rigid) {
  const Bounds box = box_of(*rigid.object, 0);
  const btSoftBody& body = *soft.soft->body;
  for (int node = 0; node < body.m_nodes.size(); ++node) {
    const btVector3& x = body.m_nodes[node].m_x;
    if (!box.overlaps({x, x})) continue;
    const ConvexCore::Depth depth = rigid.depth_of(to_doubles(x));
    if (!depth.is_inside) continue;
    const double distance = -depth.depth - soft.margin - rigid.margin;
    if (!(distance <= double(threshold_))) continue;
    const Vec3d surface_point = to_doubles(x) + depth.depth * depth.normal;
    tell_in_order({soft.object, kNodePart, node, to_doubles(x)}, {rigid.object, -1, -1, surface_point}, depth.normal,
                  distance);
  }
}

/// Reports a contact with the tested object as side a.
void ContactTest::tell_in_order(const ReportedSide& a, const ReportedSide& b, Vec3d normal, double distance) {
  if (a.object == &object_) {
    tell(a, b, normal, distance, callback_);
  } else {
    tell(b, a, -1.0 * normal, distance, callback_);
  }
}

}  // namespace

void test_contacts(WorldMirror& bodies, btCollisionObject& object, const std::vector<btCollisionObject*>& others,
                   btCollisionWorld::ContactResultCallback& callback) {
  ContactTest(bodies, object, callback).run(others);
}

}  // namespace softcd::bullet

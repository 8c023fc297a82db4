#include "questions.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "body_ids.hpp"
#include "bytes.hpp"
#include "softcd/bullet/body_contacts.hpp"

namespace softcd::bullet::pybullet {
namespace {

/// A client's soft bodies while one batch is answered.
class Interview {
 public:
  Interview(WorldProbe& bodies, const btDynamicsWorld& world)
      : bodies_(bodies), world_(world), probe_(bodies.soft_bodies()) {}

  template <class Question, class Answer>
  std::string each(const std::string& questions, Span<const Answer> (Probe::*ask)(Span<const Question>)) {
    return named_bytes((probe_.*ask)(values_in<Question>(questions)));
  }
  template <class Question, class Answer>
  std::string lists(const std::string& questions, AnswerLists<Answer> (Probe::*ask)(Span<const Question>)) {
    return bytes_of((probe_.*ask)(values_in<Question>(questions)));
  }
  std::string distances(const std::string& pairs) { return named_bytes(probe_.distances(pairs_in(pairs))); }
  std::string intersections(const std::string& pairs) { return bytes_of(probe_.intersections(pairs_in(pairs))); }
  std::string has_intersections(const std::string& pair) {
    return {probe_.has_intersections(pairs_in(pair).at(0)) ? '\1' : '\0'};
  }
  /// The questions are the number of hulls, where each begins among the points and at last their number, all as 64-bit
  /// integers; then radii and points as doubles.
  std::string hull_overlaps(const std::string& questions) {
    const std::size_t count = values_in<std::uint64_t>(questions.substr(0, sizeof(std::uint64_t))).at(0);
    const std::size_t begins_at = sizeof(std::uint64_t);
    const std::size_t radii_at = begins_at + (count + 1) * sizeof(std::uint64_t);
    const std::size_t points_at = radii_at + count * sizeof(double);
    const auto begins = values_in<std::uint64_t>(questions.substr(begins_at, radii_at - begins_at));
    const auto radii = values_in<double>(questions.substr(radii_at, points_at - radii_at));
    const auto points = values_in<Vec3d>(questions.substr(points_at));
    std::vector<ProbeHull> hulls;
    for (std::size_t i = 0; i < count; ++i) {
      const auto size = static_cast<std::size_t>(begins[i + 1] - begins[i]);
      hulls.push_back({{points.data() + begins[i], size}, radii[i]});
    }
    return bytes_of(probe_.overlaps(Span<const ProbeHull>(hulls)));
  }

 private:
  using Names = std::array<std::int32_t, 2>;

  BodyId id_of(std::int32_t name) const {
    return name == -1 ? BodyId() : bodies_.body_id(soft_body_with(world_, name));
  }
  std::vector<ProbeBodies> pairs_in(const std::string& bytes) const {
    std::vector<ProbeBodies> pairs;
    for (const Names& names : values_in<Names>(bytes)) pairs.push_back({id_of(names[0]), id_of(names[1])});
    return pairs;
  }

  void name(BodyId& body) const {
    if (body != BodyId()) body.value = static_cast<std::uint32_t>(ids_of(bodies_.soft_body(body)).body);
  }
  void name(RayHit& hit) const { name(hit.body); }
  void name(ClosestPoint& point) const { name(point.body); }
  void name(TriangleOverlap& overlap) const { name(overlap.body); }
  void name(BodyDistance& distance) const {
    name(distance.body_a);
    name(distance.body_b);
  }
  void name(TriangleIntersection& intersection) const {
    name(intersection.body_a);
    name(intersection.body_b);
  }
  template <class Answer>
  std::string named_bytes(Span<const Answer> answers) const {
    std::vector<Answer> named(answers.begin(), answers.end());
    for (Answer& answer : named) name(answer);
    return pybullet::bytes_of(named);
  }
  template <class Answer>
  std::string bytes_of(const AnswerLists<Answer>& lists) const {
    if (lists.begins().empty()) return std::string(sizeof(std::uint64_t), '\0');
    return pybullet::bytes_of(lists.begins()) + named_bytes(lists.all());
  }

  WorldProbe& bodies_;
  const btDynamicsWorld& world_;
  Probe& probe_;
};

using Answerer = std::string (*)(Interview&, const std::string& questions);

const std::map<std::string, Answerer>& answerers() {
  static const std::map<std::string, Answerer> all = {
      {"first_hits", [](Interview& i, const std::string& q) { return i.each<Ray, RayHit>(q, &Probe::first_hits); }},
      {"all_hits", [](Interview& i, const std::string& q) { return i.lists<Ray, RayHit>(q, &Probe::all_hits); }},
      {"closest_points",
       [](Interview& i, const std::string& q) { return i.each<ProbePoint, ClosestPoint>(q, &Probe::closest_points); }},
      {"sphere_overlaps",
       [](Interview& i, const std::string& q) { return i.lists<ProbeSphere, TriangleOverlap>(q, &Probe::overlaps); }},
      {"capsule_overlaps",
       [](Interview& i, const std::string& q) { return i.lists<ProbeCapsule, TriangleOverlap>(q, &Probe::overlaps); }},
      {"box_overlaps",
       [](Interview& i, const std::string& q) { return i.lists<ProbeBox, TriangleOverlap>(q, &Probe::overlaps); }},
      {"oriented_box_overlaps",
       [](Interview& i, const std::string& q) {
         return i.lists<ProbeOrientedBox, TriangleOverlap>(q, &Probe::overlaps);
       }},
      {"distances", [](Interview& i, const std::string& q) { return i.distances(q); }},
      {"hull_overlaps", [](Interview& i, const std::string& q) { return i.hull_overlaps(q); }},
      {"has_intersections", [](Interview& i, const std::string& q) { return i.has_intersections(q); }},
      {"intersections", [](Interview& i, const std::string& q) { return i.intersections(q); }},
  };
  return all;
}

struct NearFeatures {
  ObjectIds a, b;
  std::int32_t feature_a, index_a;  ///< a ContactSide::Feature, and its number in the body
  std::int32_t feature_b, index_b;
  std::array<double, 3> position_a, position_b;
  std::array<double, 3> normal;
  double distance;
};
static_assert(sizeof(NearFeatures) == 112);

std::int32_t feature_of(int part) {
  using Feature = ContactSide::Feature;
  const Feature feature = part == kNodePart   ? Feature::node
                          : part == kFacePart ? Feature::face
                          : part == kEdgePart ? Feature::edge
                                              : Feature::object;
  return static_cast<std::int32_t>(feature);
}

bool is_soft(const btCollisionObject& object) {
  return object.getInternalType() == btCollisionObject::CO_SOFT_BODY;
}

/// Collects pairs of features of which one is a soft body's.
class NearFeaturesCallback final : public btCollisionWorld::ContactResultCallback {
 public:
  NearFeaturesCallback(const btCollisionObject& object, double max_distance) : object_(object) {
    m_closestDistanceThreshold = max_distance;
  }
  bool needsCollision(btBroadphaseProxy* proxy) const override {
    const auto& other = *static_cast<const btCollisionObject*>(proxy->m_clientObject);
    return (is_soft(object_) || is_soft(other)) && other.getInternalType() != btCollisionObject::CO_USER_TYPE;
  }
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* a, int part_a, int index_a,
                           const btCollisionObjectWrapper* b, int part_b, int index_b) override {
    const auto vector = [](const btVector3& v) { return std::array<double, 3>{v.x(), v.y(), v.z()}; };
    found.push_back({ids_of(a->getCollisionObject()), ids_of(b->getCollisionObject()), feature_of(part_a), index_a,
                     feature_of(part_b), index_b, vector(point.getPositionWorldOnA()),
                     vector(point.getPositionWorldOnB()), vector(point.m_normalWorldOnB), point.getDistance()});
    return 0;
  }

  std::vector<NearFeatures> found;

 private:
  const btCollisionObject& object_;
};

}  // namespace

std::string ask(WorldProbe& bodies, const btDynamicsWorld& world, const std::string& name,
                const std::string& questions) {
  const auto found = answerers().find(name);
  if (found == answerers().end()) throw InvalidInput(fmt::format("softcd's plugin knows no question '{}'.", name));
  Interview interview(bodies, world);
  return found->second(interview, questions);
}

std::string bytes_of_near_features(WorldProbe& bodies, btDynamicsWorld& world, int body, double max_distance) {
  std::vector<btCollisionObject*> parts;
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    const bool is_own = objects[i]->getInternalType() == btCollisionObject::CO_USER_TYPE;
    if (!is_own && ids_of(objects[i]).body == body) parts.push_back(objects[i]);
  }
  if (parts.empty()) throw InvalidInput(fmt::format("body: {} is no body of this client.", body));
  std::vector<NearFeatures> found;
  for (btCollisionObject* const part : parts) {
    NearFeaturesCallback callback(*part, max_distance);
    bodies.contact_test(*part, callback);
    found.insert(found.end(), callback.found.begin(), callback.found.end());
  }
  return bytes_of(found);
}

std::string bytes_of_nodes(const btSoftBody& body) {
  std::vector<std::array<double, 7>> nodes;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& x = body.m_nodes[i].m_x;
    const btVector3& v = body.m_nodes[i].m_v;
    nodes.push_back({x.x(), x.y(), x.z(), v.x(), v.y(), v.z(), body.getMass(i)});
  }
  return bytes_of(nodes);
}

std::string bytes_of_faces(const btSoftBody& body) {
  std::vector<std::array<std::int32_t, 3>> faces(static_cast<std::size_t>(body.m_faces.size()));
  for (int i = 0; i < body.m_faces.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      faces[static_cast<std::size_t>(i)][k] = static_cast<std::int32_t>(body.m_faces[i].m_n[k] - &body.m_nodes[0]);
    }
  }
  return bytes_of(faces);
}

}  // namespace softcd::bullet::pybullet

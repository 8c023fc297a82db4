#include "contact_answers.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "body_ids.hpp"
#include "bytes.hpp"

namespace softcd::bullet::pybullet {
namespace {

using Vector = std::array<double, 3>;
constexpr Vector kUnknownVector = {kUnknown, kUnknown, kUnknown};

struct PairRecord {
  ObjectIds a, b;
  std::int32_t state;
  std::uint32_t has_impulses;
  std::int32_t contact_count;
  std::int32_t ended_count;
  Vector impulse_a, impulse_b;
  Vector force_a, force_b;
};
static_assert(sizeof(PairRecord) == 128);

struct SideRecord {
  std::int32_t feature;
  std::int32_t face;
  std::array<std::int32_t, 3> nodes;
  std::array<float, 3> weights;
  Vector position;
};
static_assert(sizeof(SideRecord) == 56);

struct ContactRecord {
  ObjectIds ids_a, ids_b;
  std::int32_t pair;
  std::uint32_t is_new;
  SideRecord a, b;
  Vector normal;
  double depth;
  double time_of_impact;
  Vector impulse_a, impulse_b;
  Vector force_a, force_b;
};
static_assert(sizeof(ContactRecord) == 272);

struct EdgeSideRecord {
  std::int32_t body;
  std::array<std::int32_t, 2> nodes;
  std::array<float, 2> weights;
};

struct EdgeContactRecord {
  EdgeSideRecord a, b;
  Vector normal;
  double distance;
  double time_of_impact;
};
static_assert(sizeof(EdgeContactRecord) == 80);

struct IntersectingBodiesRecord {
  std::int32_t body_a, body_b;
  std::uint32_t regions;
  std::uint64_t steps;
  double curve_length;
};
static_assert(sizeof(IntersectingBodiesRecord) == 32);

/// The world's objects. Recognizes pointers to objects that it has deleted.
class ObjectsInWorld {
 public:
  explicit ObjectsInWorld(const btDynamicsWorld& world) {
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) objects_.push_back(objects[i]);
    std::sort(objects_.begin(), objects_.end(), std::less<>());
  }
  bool have(const btCollisionObject* object) const {
    return std::binary_search(objects_.begin(), objects_.end(), object, std::less<>());
  }

 private:
  std::vector<const btCollisionObject*> objects_;
};

Vector vector(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

SideRecord record(const ContactSide& side) {
  SideRecord record{static_cast<std::int32_t>(side.feature), side.face, {}, {}, vector(side.position)};
  std::copy_n(side.nodes, 3, record.nodes.begin());
  std::transform(side.weights, side.weights + 3, record.weights.begin(), [](btScalar w) { return float(w); });
  return record;
}

EdgeSideRecord record(const EdgeContact::Side& side) {
  return {ids_of(side.body).body,
          {side.nodes[0], side.nodes[1]},
          {static_cast<float>(side.weights[0]), static_cast<float>(side.weights[1])}};
}

ContactRecord record(const BodyPairContacts& pair, std::size_t place, const BodyContact& contact) {
  ContactRecord record{};
  record.ids_a = ids_of(pair.a);
  record.ids_b = ids_of(pair.b);
  record.pair = static_cast<std::int32_t>(place);
  record.is_new = contact.is_new ? 1 : 0;
  record.a = pybullet::record(contact.a);
  record.b = pybullet::record(contact.b);
  record.normal = vector(contact.normal);
  record.depth = contact.depth;
  record.time_of_impact = contact.time_of_impact;
  return record;
}

/// Sets the impulses of a PairRecord or a ContactRecord.
template <class Record>
void set_impulses(Record& record, bool are_known, const btVector3& a, const btVector3& b, double step_length) {
  const auto force = [&](const btVector3& impulse) { return vector(impulse * btScalar(1 / step_length)); };
  record.impulse_a = are_known ? vector(a) : kUnknownVector;
  record.impulse_b = are_known ? vector(b) : kUnknownVector;
  record.force_a = are_known ? force(a) : kUnknownVector;
  record.force_b = are_known ? force(b) : kUnknownVector;
}

}  // namespace

std::string bytes_of_contacts(const std::vector<BodyPairContacts>& pairs, double step_length) {
  std::vector<PairRecord> records;
  std::vector<ContactRecord> contacts, ended;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const BodyPairContacts& pair = pairs[i];
    const bool has_ended = pair.state == BodyPairContacts::State::ended;
    PairRecord of_pair{};
    of_pair.a = ids_of(pair.a);
    of_pair.b = ids_of(pair.b);
    of_pair.state = static_cast<std::int32_t>(pair.state);
    of_pair.has_impulses = pair.has_impulses ? 1 : 0;
    of_pair.contact_count = static_cast<std::int32_t>(pair.contacts.size());
    of_pair.ended_count = static_cast<std::int32_t>(pair.ended.size());
    set_impulses(of_pair, pair.has_impulses || has_ended, pair.impulse_a, pair.impulse_b, step_length);
    records.push_back(of_pair);
    for (const BodyContact& contact : pair.contacts) {
      contacts.push_back(record(pair, i, contact));
      set_impulses(contacts.back(), pair.has_impulses, contact.impulse_a, contact.impulse_b, step_length);
    }
    for (const BodyContact& contact : pair.ended) {
      ended.push_back(record(pair, i, contact));
      set_impulses(ended.back(), false, contact.impulse_a, contact.impulse_b, step_length);
    }
  }
  const std::array<std::uint64_t, 3> counts = {records.size(), contacts.size(), ended.size()};
  return bytes_of(counts) + bytes_of(records) + bytes_of(contacts) + bytes_of(ended);
}

std::string bytes_of_edge_contacts(const std::vector<EdgeContact>& contacts, const btDynamicsWorld& world) {
  const ObjectsInWorld objects(world);
  std::vector<EdgeContactRecord> records;
  records.reserve(contacts.size());
  for (const EdgeContact& contact : contacts) {
    if (!objects.have(contact.a.body) || !objects.have(contact.b.body)) continue;
    records.push_back(
        {record(contact.a), record(contact.b), vector(contact.normal), contact.distance, contact.time_of_impact});
  }
  return bytes_of(records);
}

std::string bytes_of_intersecting_bodies(const std::vector<IntersectingBodies>& pairs, const btDynamicsWorld& world) {
  const ObjectsInWorld objects(world);
  std::vector<IntersectingBodiesRecord> records;
  for (const IntersectingBodies& pair : pairs) {
    if (!objects.have(pair.a) || !objects.have(pair.b)) continue;
    records.push_back({ids_of(pair.a).body, ids_of(pair.b).body, pair.regions, pair.steps, pair.curve_length});
  }
  return bytes_of(records);
}

}  // namespace softcd::bullet::pybullet

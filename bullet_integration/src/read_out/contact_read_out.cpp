#include "read_out/contact_read_out.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "BulletCollision/BroadphaseCollision/btBroadphaseInterface.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

namespace softcd::bullet {
namespace {

using State = BodyPairContacts::State;

/// Identifies the touching features of two bodies.
using FeatureKey = std::array<int, 6>;

FeatureKey key_of(const BodyContact& contact) {
  FeatureKey key;
  int i = 0;
  for (const ContactSide* side : {&contact.a, &contact.b}) {
    key[i++] = static_cast<int>(side->feature);
    key[i++] = side->feature == ContactSide::Feature::face ? side->face : side->nodes[0];
    key[i++] = side->feature == ContactSide::Feature::edge ? side->nodes[1] : -1;
  }
  return key;
}

std::vector<FeatureKey> sorted_keys(const std::vector<BodyContact>& contacts) {
  std::vector<FeatureKey> keys;
  keys.reserve(contacts.size());
  for (const BodyContact& contact : contacts) keys.push_back(key_of(contact));
  std::sort(keys.begin(), keys.end());
  return keys;
}

void compare_contacts(BodyPairContacts& now, const std::vector<BodyContact>& before) {
  const std::vector<FeatureKey> keys_before = sorted_keys(before);
  const std::vector<FeatureKey> keys_now = sorted_keys(now.contacts);
  const auto is_among = [](const std::vector<FeatureKey>& keys, const BodyContact& contact) {
    return std::binary_search(keys.begin(), keys.end(), key_of(contact));
  };
  for (BodyContact& contact : now.contacts) contact.is_new = !is_among(keys_before, contact);
  for (const BodyContact& contact : before) {
    if (!is_among(keys_now, contact)) now.ended.push_back(contact);
  }
}

/// Lists all objects of a broad phase.
class Listing : public btBroadphaseAabbCallback {
 public:
  bool process(const btBroadphaseProxy* proxy) override {
    keys.emplace(*proxy);
    return true;
  }

  std::set<BodyKey> keys;
};

std::set<BodyKey> objects_in(btBroadphaseInterface& broadphase) {
  Listing listing;
  const btVector3 corner(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
  broadphase.aabbTest(-corner, corner, listing);
  return std::move(listing.keys);
}

}  // namespace

void ContactEvents::update(const std::vector<KeyedPair>& now) {
  std::map<BodyPairKey, const BodyPairContacts*> before;
  for (const KeyedPair& pair : before_) before.emplace(pair.key, &pair.pair);
  pairs_.clear();
  keys_.clear();
  for (const KeyedPair& pair : now) {
    pairs_.push_back(pair.pair);
    keys_.push_back(pair.key);
    const auto known = before.find(pair.key);
    pairs_.back().state = known != before.end() ? State::persists : State::begun;
    compare_contacts(pairs_.back(), known != before.end() ? known->second->contacts : std::vector<BodyContact>());
    if (known != before.end()) before.erase(known);
  }
  for (const KeyedPair& pair : before_) {
    if (before.count(pair.key) == 0) continue;
    pairs_.push_back({pair.pair.a, pair.pair.b, State::ended, {}, pair.pair.contacts});
    keys_.push_back(pair.key);
  }
  before_ = now;
}

void ContactEvents::forget_what_is_gone(btBroadphaseInterface* broadphase) {
  if (pairs_.empty()) return;
  const std::set<BodyKey> living = broadphase != nullptr ? objects_in(*broadphase) : std::set<BodyKey>();
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (living.count(keys_[i].first) == 0) pairs_[i].a = nullptr;
    if (living.count(keys_[i].second) == 0) pairs_[i].b = nullptr;
  }
}

bool ContactImpulses::add_to(Impulse& sum, const ContactSource& source) const {
  const auto known = impulses_.find({source.owner, source.array});
  if (known == impulses_.end()) return false;
  for (int i = source.first; i < source.first + source.count; ++i) sum += known->second[static_cast<std::size_t>(i)];
  return true;
}

KeyedPair& ContactReadOut::pair_of(const BodyPairKey& key) {
  const auto [place, is_new] = places_.try_emplace(key, now_.size());
  if (is_new) {
    now_.push_back({key, {}, {}});
    now_.back().pair.a = btSoftBody::upcast(const_cast<btCollisionObject*>(key.first.object));
    now_.back().pair.b = key.second.object;
  }
  return now_[place->second];
}

void ContactReadOut::read(ReadContacts read_contacts, Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase,
                          const NotesOfStep& notes) {
  before_ = std::exchange(now_, {});
  places_.clear();
  read_.clear();
  Keys sleepers;
  for (const btSoftBody* body : bodies) (body->isActive() ? read_ : sleepers).emplace(*body);
  const ContactReader reader(bodies, notes);
  std::vector<ReadContact> contacts;
  for (const btSoftBody* body : bodies) {
    if (body->isActive()) (reader.*read_contacts)(*body, contacts);
  }
  for (const ReadContact& read : contacts) {
    KeyedPair& pair = pair_of({BodyKey(*read.a), BodyKey(*read.b)});
    pair.pair.contacts.push_back(read.contact);
    pair.origins.push_back({read.source, read.owner_is_b});
  }
  keep_contacts_of(sleepers, broadphase);
  is_unread_ = true;
}

void ContactReadOut::keep_contacts_of_new_sleepers(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase) {
  Keys sleepers;
  for (const btSoftBody* body : bodies) {
    if (!body->isActive() && read_.count(BodyKey(*body)) != 0) sleepers.emplace(*body);
  }
  if (sleepers.empty()) return;
  drop_contacts_of(sleepers);
  keep_contacts_of(sleepers, broadphase);
}

void ContactReadOut::drop_contacts_of(const Keys& sleepers) {
  const std::vector<KeyedPair> all = std::exchange(now_, {});
  places_.clear();
  for (const KeyedPair& pair : all) {
    for (std::size_t i = 0; i < pair.origins.size(); ++i) {
      if (sleepers.count(pair.origins[i].owner_is_b ? pair.key.second : pair.key.first) != 0) continue;
      KeyedPair& kept = pair_of(pair.key);
      kept.pair.contacts.push_back(pair.pair.contacts[i]);
      kept.origins.push_back(pair.origins[i]);
    }
  }
}

/// Bullet neither solves nor clears the entries of a body that sleeps. The objects that they point to may be gone. The
/// contacts keep the impulses that they had when the body fell asleep.
void ContactReadOut::keep_contacts_of(const Keys& sleepers, btBroadphaseInterface& broadphase) {
  if (sleepers.empty() || before_.empty()) return;
  const Keys living = objects_in(broadphase);
  for (const KeyedPair& pair : before_) {
    if (living.count(pair.key.first) == 0 || living.count(pair.key.second) == 0) continue;
    for (std::size_t i = 0; i < pair.origins.size(); ++i) {
      const KeyedPair::Origin& origin = pair.origins[i];
      if (sleepers.count(origin.owner_is_b ? pair.key.second : pair.key.first) == 0) continue;
      KeyedPair& kept = pair_of(pair.key);
      BodyContact& contact = kept.pair.contacts.emplace_back(pair.pair.contacts[i]);
      ContactImpulses::Impulse impulse = {contact.impulse_a, contact.impulse_b};
      if (origin.owner_is_b) std::swap(impulse.on_owner, impulse.on_other);
      contact.impulse_a.setZero();
      contact.impulse_b.setZero();
      kept.origins.push_back({origin.source, origin.owner_is_b});
      if (pair.pair.has_impulses) kept.origins.back().of_sleeper = impulse;
    }
  }
}

void ContactReadOut::set_impulses(const ContactImpulses& impulses) {
  for (KeyedPair& keyed : now_) {
    std::vector<ContactImpulses::Impulse> known(keyed.origins.size());
    bool knows_all = !impulses.is_doubtful(*keyed.key.first.object) && !impulses.is_doubtful(*keyed.key.second.object);
    for (std::size_t i = 0; i < known.size(); ++i) {
      const KeyedPair::Origin& origin = keyed.origins[i];
      if (origin.of_sleeper.has_value()) {
        known[i] = *origin.of_sleeper;
      } else {
        knows_all = knows_all && impulses.add_to(known[i], origin.source);
      }
    }
    if (!knows_all) continue;
    keyed.pair.has_impulses = true;
    for (std::size_t i = 0; i < known.size(); ++i) {
      BodyContact& contact = keyed.pair.contacts[i];
      contact.impulse_a = keyed.origins[i].owner_is_b ? known[i].on_other : known[i].on_owner;
      contact.impulse_b = keyed.origins[i].owner_is_b ? known[i].on_owner : known[i].on_other;
      keyed.pair.impulse_a += contact.impulse_a;
      keyed.pair.impulse_b += contact.impulse_b;
    }
  }
}

/// Adds the impulses of crossing prevention. An object that no impulse moves gets the opposite of the soft body's
/// impulse.
void ContactReadOut::add_crossings(const std::vector<CrossingImpulse>& crossings, Span<btSoftBody* const> bodies) {
  for (const CrossingImpulse& crossing : crossings) {
    const btRigidBody* rigid = btRigidBody::upcast(crossing.other);
    const auto first = std::find_if(bodies.begin(), bodies.end(), [&](const btSoftBody* body) {
      return body == crossing.body || body == crossing.other;
    });
    const bool is_b = first != bodies.end() && *first != crossing.body;
    const BodyKey of_body(*crossing.body);
    const BodyKey of_other(*crossing.other);
    KeyedPair& keyed = pair_of(is_b ? BodyPairKey(of_other, of_body) : BodyPairKey(of_body, of_other));
    if (keyed.origins.empty()) keyed.pair.has_impulses = true;
    if (!keyed.pair.has_impulses) continue;
    (is_b ? keyed.pair.impulse_b : keyed.pair.impulse_a) += crossing.on_body;
    if (rigid != nullptr && !(rigid->getInvMass() > 0)) keyed.pair.impulse_b -= crossing.on_body;
  }
}

const std::vector<BodyPairContacts>& ContactReadOut::since_last_step(btBroadphaseInterface* broadphase) {
  step_events_.update(now_);
  step_events_.forget_what_is_gone(broadphase);
  return step_events_.pairs();
}

const std::vector<BodyPairContacts>& ContactReadOut::since_last_call(btBroadphaseInterface* broadphase) {
  if (std::exchange(is_unread_, false)) call_events_.update(now_);
  call_events_.forget_what_is_gone(broadphase);
  return call_events_.pairs();
}

}  // namespace softcd::bullet

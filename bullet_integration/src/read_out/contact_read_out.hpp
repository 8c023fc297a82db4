#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>

#include "crossings/crossing_impulses.hpp"
#include "read_out/contact_reader.hpp"
#include "softcd/bullet/settings.hpp"

class btBroadphaseInterface;

namespace softcd::bullet {

/// Tells a body from another one at the same address later: by its proxy's number.
struct BodyKey {
  const btCollisionObject* object = nullptr;
  int proxy = 0;

  explicit BodyKey(const btCollisionObject& of) : BodyKey(*of.getBroadphaseHandle()) {}
  explicit BodyKey(const btBroadphaseProxy& of)
      : object(static_cast<const btCollisionObject*>(of.m_clientObject)), proxy(of.m_uniqueId) {}
  friend bool operator<(const BodyKey& a, const BodyKey& b) {
    return std::pair(a.object, a.proxy) < std::pair(b.object, b.proxy);
  }
};
using BodyPairKey = std::pair<BodyKey, BodyKey>;

/// The impulses that the solver gave through the entries of Bullet's arrays.
class ContactImpulses {
 public:
  struct Impulse {
    btVector3 on_owner{0, 0, 0};  ///< on the entry's node, or on the soft body where it touches a rigid object
    btVector3 on_other{0, 0, 0};

    Impulse& operator+=(const Impulse& more) {
      on_owner += more.on_owner;
      on_other += more.on_other;
      return *this;
    }
  };

  void clear() {
    impulses_.clear();
    doubtful_.clear();
  }
  std::vector<Impulse>& of(const btSoftBody& owner, ContactArray array) { return impulses_[{&owner, array}]; }
  /// Null when nobody knows them.
  std::vector<Impulse>* find(const btSoftBody& owner, ContactArray array) {
    const auto known = impulses_.find({&owner, array});
    return known != impulses_.end() ? &known->second : nullptr;
  }
  /// Adds the impulses of all the source's entries. False when they are not known.
  bool add_to(Impulse& sum, const ContactSource& source) const;

  /// No impulse on this body is known.
  void doubt(const btCollisionObject* body) { doubtful_.insert(body); }
  bool is_doubtful(const btCollisionObject& body) const { return doubtful_.count(&body) != 0; }

 private:
  std::map<std::pair<const btSoftBody*, ContactArray>, std::vector<Impulse>> impulses_;
  std::set<const btCollisionObject*> doubtful_;
};

/// The contacts of a pair, with where they stand in Bullet's arrays.
struct KeyedPair {
  BodyPairKey key;
  BodyPairContacts pair;
  struct Origin {
    ContactSource source;
    bool owner_is_b;
    /// The impulse with which a sleeping owner's contact fell asleep, if it is known.
    std::optional<ContactImpulses::Impulse> of_sleeper = std::nullopt;
  };
  std::vector<Origin> origins;  ///< of pair.contacts
};

/// What has begun, persists and has ended between two lists of pairs.
class ContactEvents {
 public:
  /// Compares with the list of the last call, which may be of many steps ago.
  void update(const std::vector<KeyedPair>& now);
  const std::vector<BodyPairContacts>& pairs() const { return pairs_; }
  /// Nulls bodies that are not in it: the rest of a pair stays readable. Null: there are none any more.
  void forget_what_is_gone(btBroadphaseInterface* broadphase);

 private:
  std::vector<KeyedPair> before_;
  std::vector<BodyPairContacts> pairs_;
  std::vector<BodyPairKey> keys_;  ///< of pairs_
};

/// The contacts of a world's soft bodies in its last step.
class ContactReadOut {
 public:
  /// As the contacts stand in the arrays of these bodies, all of the world's. `broadphase` is theirs.
  void read(ReadContacts read_contacts, Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase,
            const NotesOfStep& notes);
  /// Bullet's solver may put bodies to sleep after read(), and leaves them alone then. Gives such a body the contacts
  /// of the step before.
  void keep_contacts_of_new_sleepers(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase);
  /// The same contacts' impulses, as far as they are known.
  void set_impulses(const ContactImpulses& impulses);
  /// Then: what the last pass of the step gave to these bodies, all of the world's, as impulses of pairs.
  void add_crossings(const std::vector<CrossingImpulse>& crossings, Span<btSoftBody* const> bodies);

  /// Since the step before, and since the last call. `broadphase` has what is in the world; null: nothing is.
  const std::vector<BodyPairContacts>& since_last_step(btBroadphaseInterface* broadphase);
  const std::vector<BodyPairContacts>& since_last_call(btBroadphaseInterface* broadphase);

 private:
  using Keys = std::set<BodyKey>;

  void keep_contacts_of(const Keys& sleepers, btBroadphaseInterface& broadphase);
  void drop_contacts_of(const Keys& sleepers);
  KeyedPair& pair_of(const BodyPairKey& key);

  std::vector<KeyedPair> now_, before_;
  Keys read_;                                  ///< the bodies whose contacts were read in this step, as they were awake
  std::map<BodyPairKey, std::size_t> places_;  ///< in now_
  bool is_unread_ = false;
  ContactEvents step_events_, call_events_;
};

}  // namespace softcd::bullet

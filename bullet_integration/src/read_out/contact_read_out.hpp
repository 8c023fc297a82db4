#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>

#include "bodies/body_key.hpp"
#include "crossings/crossing_impulses.hpp"
#include "read_out/contact_reader.hpp"
#include "softcd/bullet/settings.hpp"

class btBroadphaseInterface;

namespace softcd::bullet {

using BodyPairKey = std::pair<BodyKey, BodyKey>;

/// The solver's impulses for the entries of Bullet's arrays.
class ContactImpulses {
 public:
  struct Impulse {
    btVector3 on_owner{0, 0, 0};  ///< on the entry's node, or, for rigid objects, on the soft body
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
  /// Returns null if they are not known.
  std::vector<Impulse>* find(const btSoftBody& owner, ContactArray array) {
    const auto known = impulses_.find({&owner, array});
    return known != impulses_.end() ? &known->second : nullptr;
  }
  /// Adds the impulses of all the source's entries. Returns false if they are not known.
  bool add_to(Impulse& sum, const ContactSource& source) const;

  /// Marks all impulses on this body as not known.
  void doubt(const btCollisionObject* body) { doubtful_.insert(body); }
  bool is_doubtful(const btCollisionObject& body) const { return doubtful_.count(&body) != 0; }

 private:
  std::map<std::pair<const btSoftBody*, ContactArray>, std::vector<Impulse>> impulses_;
  std::set<const btCollisionObject*> doubtful_;
};

/// The contacts of a pair, with their places in Bullet's arrays.
struct KeyedPair {
  BodyPairKey key;
  BodyPairContacts pair;
  struct Origin {
    ContactSource source;
    bool owner_is_b;
    /// The contact's impulse when its owner fell asleep, if it is known.
    std::optional<ContactImpulses::Impulse> of_sleeper = std::nullopt;
  };
  std::vector<Origin> origins;  ///< one for each of pair.contacts
};

/// Compares two lists of pairs: contacts that have begun, persist and have ended.
class ContactEvents {
 public:
  /// Compares with the list of the last call, which may be many steps old.
  void update(const std::vector<KeyedPair>& now);
  const std::vector<BodyPairContacts>& pairs() const { return pairs_; }
  /// Sets pointers to bodies that are not in the broad phase to null. The rest of a pair stays readable. If
  /// `broadphase` is null, no bodies are left.
  void forget_what_is_gone(btBroadphaseInterface* broadphase);

 private:
  std::vector<KeyedPair> before_;
  std::vector<BodyPairContacts> pairs_;
  std::vector<BodyPairKey> keys_;  ///< one for each of pairs_
};

/// The contacts of a world's soft bodies in its last step. Owned by WorldReadOut.
class ContactReadOut {
 public:
  /// Reads the contacts from the arrays of `bodies`, which are all of the world's. `broadphase` is the world's.
  void read(ReadContacts read_contacts, Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase,
            const NotesOfStep& notes);
  /// Bullet's solver may put bodies to sleep after read(), and leaves them alone then. Gives such a body the contacts
  /// of the step before.
  void keep_contacts_of_new_sleepers(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase);
  /// The same contacts' impulses, as far as they are known.
  void set_impulses(const ContactImpulses& impulses);
  /// Adds the impulses of the step's last pass to the pairs. Call it after set_impulses(). `bodies` are all of the
  /// world's.
  void add_crossings(const std::vector<CrossingImpulse>& crossings, Span<btSoftBody* const> bodies);

  /// Returns the events since the last step, or since the last call. `broadphase` has the world's bodies; null if there
  /// are none.
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

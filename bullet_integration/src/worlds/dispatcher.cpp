#include "softcd/bullet/dispatcher.hpp"

#include <string>
#include <utility>

#include "worlds/world_queries.hpp"

namespace softcd::bullet {
namespace {

// Processes Bullet's pairs: all but the vertex-face pairs of soft bodies.
class NativePairs : public btOverlapCallback {
 public:
  NativePairs(btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) : dispatcher_(dispatcher), info_(info) {}

  bool processOverlap(btBroadphasePair& pair) override {
    const auto [a, b] = soft_bodies_of(pair);
    const bool ours = a != nullptr && b != nullptr && is_vertex_face_pair(kClassicEnds, *a, *b);
    if (!ours) dispatcher_.getNearCallback()(pair, dispatcher_, info_);
    return false;
  }

 private:
  btCollisionDispatcher& dispatcher_;
  const btDispatcherInfo& info_;
};

}  // namespace

Dispatcher::Dispatcher(btCollisionConfiguration* configuration, Broadphase& broadphase, const Settings& settings)
    : btCollisionDispatcher(configuration),
      broadphase_(broadphase),
      living_broadphase_(broadphase.self_),
      detection_(kClassicWorld, settings) {
  broadphase_.attach(detection_.settings());
  detection_.queries_->prevents_crossings_later = false;
  detection_.queries_->broadphase = [this] { return living_broadphase_.lock().get(); };
}

Dispatcher::~Dispatcher() {
  if (const std::shared_ptr<Broadphase> broadphase = living_broadphase_.lock()) broadphase->detach();
}

void Dispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* pair_cache, const btDispatcherInfo& info,
                                           btDispatcher* dispatcher) {
  if (pair_cache != broadphase_.getOverlappingPairCache()) {
    btCollisionDispatcher::dispatchAllCollisionPairs(pair_cache, info, dispatcher);
    return;
  }
  broadphase_.restore_vertex_face_flags();
  NativePairs native_pairs(*this, info);
  WorldQueries& queries = *detection_.queries_;
  queries.process_pairs(broadphase_.soft_bodies(), PairGate(*this, *pair_cache, info),
                        [&] { pair_cache->processAllOverlappingPairs(&native_pairs, dispatcher, info); });
  queries.read_contacts(broadphase_.soft_bodies(), broadphase_);
  for (btSoftBody* body : broadphase_.soft_bodies()) {
    if (!queries.mirror.has(*body)) continue;
    WorldMirror::Member& member = queries.mirror.member(*body);
    member.is_in_parts = replace_face_tree(*body, member.topology_changed, member.is_in_parts);
  }
  if (!std::exchange(queries.prevents_crossings_later, false)) warn_of_missing_end();
}

/// Warns once of each part of softcd's step that comes after the solver.
void Dispatcher::warn_of_missing_end() {
  const Settings& settings = detection_.settings();
  if (!settings.log) return;
  constexpr const char* kRemedy =
      "make the world a softcd::bullet::SoftRigidDynamicsWorld or SoftMultiBodyDynamicsWorld, or use a "
      "btCollisionDispatcher and softcd::bullet::attach (reported once)";
  if (settings.detection == Detection::ccd && !std::exchange(has_warned_of_crossings_, true)) {
    settings.log(LogLevel::warning,
                 std::string("continuous detection: a softcd::bullet::Dispatcher under a world of Bullet's own is not "
                             "called after the solver, so nodes that the solver moves through another surface still "
                             "pass through it; to prevent this ") +
                     kRemedy);
  }
  if (settings.untangle == Untangle::all && !std::exchange(has_warned_of_untangling_, true)) {
    settings.log(LogLevel::warning,
                 std::string("untangling: a softcd::bullet::Dispatcher under a world of Bullet's own is not called "
                             "after the solver, so bodies that intersect stay as they are; to move them apart ") +
                     kRemedy);
  }
}

bool Dispatcher::serves(const btBroadphaseInterface& broadphase) const {
  return &broadphase == &broadphase_;
}

}  // namespace softcd::bullet

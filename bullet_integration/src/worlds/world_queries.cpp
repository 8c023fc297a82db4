#include "worlds/world_queries.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <new>

#include "LinearMath/btQuickprof.h"

namespace softcd::bullet {
namespace {

/// Returns the settings with the world's choice of EdgeContacts where the app leaves it.
Settings chosen(const WorldKind& kind, Settings settings) {
  if (settings.edge_contacts == EdgeContacts::automatic) settings.edge_contacts = kind.automatic_edge_contacts;
  return settings;
}

}  // namespace

WorldQueries::WorldQueries(const WorldKind& kind, const Settings& settings)
    : kind_(kind),
      settings_(chosen(kind, settings)),
      mirror(kind.contacts.ends, settings_),
      contacts("the step has Bullet's own contacts between soft bodies", kind.contacts, mirror, settings_),
      crossings("the step prevents no crossings", kind.crossings, mirror, settings_),
      untangling("the step moves no intersecting bodies apart", kind.crossings, mirror, settings_),
      rigid_meshes("the step has Bullet's own contacts of soft bodies with rigid meshes", kind.contacts, mirror,
                   settings_),
      convex_shapes("the step has only Bullet's own contacts of soft bodies with convex shapes", kind.contacts, mirror,
                    settings_),
      read_out(kind.read_contacts, settings_),
      rays(kind.ray_targets, settings_),
      massless_paths(kind.contacts.ends) {}

BackedNodes WorldQueries::backed_nodes(Span<btSoftBody* const> bodies) {
  try {
    return BackedNodes(bodies);
  } catch (...) {
    failed_responses_.note(settings_);
    return {};
  }
}

void WorldQueries::find_late_contacts(Span<btSoftBody* const> bodies) {
  late_contacts.clear();
  if (settings_.detection != Detection::dcd || settings_.contacts == Contacts::all) return;
  try {
    late_contacts.find(bodies);
  } catch (...) {
    failed_responses_.note(settings_);
  }
}

void WorldQueries::set_settings(const Settings& settings) {
  const Settings before = std::exchange(settings_, chosen(kind_, settings));
  try {
    follow_settings();
  } catch (...) {
    settings_ = before;
    follow_settings();
    throw;
  }
  const bool finds_more =
      (settings.rigid_meshes && !before.rigid_meshes) ||
      (settings.convex_shapes != before.convex_shapes && before.convex_shapes == ConvexShapes::nodes);
  if (finds_more) forget_algorithms();
}

void WorldQueries::follow_settings() {
  mirror.follow_settings();
  contacts.follow_settings();
  crossings.follow_settings();
  untangling.follow_settings();
  rigid_meshes.follow_settings();
  convex_shapes.follow_settings();
  read_out.follow_settings();
}

bool WorldQueries::start_contacts(Span<btSoftBody* const> bodies, const PairGate& gate) {
  const WorldPairs pairs = pairs_of(gate);
  if (!contacts.run([&](ContactDetection& detection) { detection.read(bodies); })) return false;
  if (untangles()) {
    untangling.run([&](Untangling& regions) {
      const std::vector<ProbeBodies> tangled = contacts.get()->tangled_bodies();
      regions.find(bodies, std::cref(pairs), {tangled.data(), tangled.size()});
    });
  }
  return contacts.run([&](ContactDetection& detection) { detection.start(std::cref(pairs)); });
}

void WorldQueries::finish_contacts(bool has_started, Span<btSoftBody* const> bodies, const PairGate& gate) {
  const bool has_finished = has_started && contacts.run([this](ContactDetection& detection) {
    detection.finish(prevents_crossings_later, released());
  });
  if (has_finished) return;
  const WorldPairs pairs = pairs_of(gate);
  kind_.detect_natively(bodies, gate, std::cref(pairs));  // which takes no memory
}

void WorldQueries::find_mesh_contacts(btCollisionDispatcher& dispatcher, const PairGate& gate) {
  const RigidPairs::Collected collected = rigid_pairs_->take_collected(RigidPairKind::mesh, gate);
  const bool has_read = rigid_meshes.run([&](RigidMeshDetection& detection) {
    if (!collected.is_complete) throw std::bad_alloc();
    read_meshes(detection, collected.pairs, gate.info().m_timeStep);
  });
  const bool has_found = has_read && rigid_meshes.run([&](RigidMeshDetection& detection) {
    for (const RigidPair& pair : collected.pairs) {
      near_meshes_.push_back(pair.soft);
      if (kind_.moves_rigid_bodies_first) late_impulses.add_on_mesh(*pair.soft);
    }
    std::sort(near_meshes_.begin(), near_meshes_.end(), std::less<>());
    detection.find_contacts(released());
  });
  if (has_found) return;
  near_meshes_.clear();
  for (const RigidPair& pair : collected.pairs) process_natively(pair, dispatcher, gate.info());
}

/// Reads the meshes, and what Settings::untangle needs of them.
void WorldQueries::read_meshes(RigidMeshDetection& detection, const std::vector<RigidPair>& pairs, btScalar time_step) {
  const auto read = [&] {
    detection.read(pairs, time_step, [this](const btSoftBody& soft, BodyId part) {
      return untangling.get() != nullptr && untangling.get()->knows(soft, part);
    });
  };
  read();
  if (!untangles()) return;
  bool has_new_pairs = false;
  untangling.run([&](Untangling& regions) { has_new_pairs = regions.search_in_meshes(detection.near_parts()); });
  if (has_new_pairs) read();
  untangling.run([&](Untangling& regions) { regions.find_in_meshes(detection.near_parts()); });
}

void WorldQueries::find_convex_contacts(const PairGate& gate) {
  const RigidPairs::Collected collected = rigid_pairs_->take_collected(RigidPairKind::convex, gate);
  convex_shapes.run([&](ConvexDetection& detection) {
    BT_PROFILE("softcd convex shapes");
    if (!collected.is_complete) throw std::bad_alloc();
    detection.read(collected.pairs, gate.info().m_timeStep);
    detection.find_contacts(/*released=*/nullptr);
    if (settings_.detection == Detection::ccd && kind_.moves_rigid_bodies_first) {
      for (const auto& [soft, object] : detection.policy().meetings()) late_impulses.add(*soft, *object);
    }
  });
}

void WorldQueries::keep_starts(Span<btSoftBody* const> bodies) {
  if (!prevents_crossings()) return;
  crossings.run([&](CrossingPrevention& prevention) { prevention.keep_starts(bodies); });
}

void WorldQueries::end_massless_paths(Span<btSoftBody* const> bodies) {
  try {
    massless_paths.end_step(bodies);
  } catch (...) {
    failed_paths_.note(settings_);
  }
}

void WorldQueries::keep_rigid_starts(const btCollisionObjectArray& objects, btScalar time_step) {
  if (!prevents_crossings() || !settings_.rigid_meshes) return;
  crossings.run([&](CrossingPrevention& prevention) { prevention.keep_rigid_starts(objects, time_step); });
}

bool WorldQueries::prevents_crossings(const btSoftBody& body) const {
  if (settings_.detection == Detection::ccd) return has_vertex_face_contacts(kind_.contacts.ends, body);
  return std::binary_search(near_meshes_.begin(), near_meshes_.end(), &body, std::less<>());
}

void WorldQueries::prevent_crossings(Span<btSoftBody* const> bodies, const btCollisionObjectArray& objects,
                                     const PairGate& gate, btScalar time_step) {
  if (settings_.untangle != Untangle::off)
    untangling.run([&](Untangling& regions) { regions.move(objects, time_step); });
  if (untangling.get() != nullptr) read_out.add_crossings(untangling.get()->impulses(), bodies);
  if (!prevents_crossings()) return;
  const auto is_wanted = [this](const btSoftBody* body) { return prevents_crossings(*body); };
  const bool has_any = std::any_of(bodies.begin(), bodies.end(), is_wanted);
  if (!has_any && crossings.get() != nullptr && crossings.get()->is_idle()) return;
  Surroundings surroundings;
  if (settings_.rigid_meshes) {
    surroundings = {&objects, [&](btSoftBody& soft, btCollisionObject& object) { return gate.admits(soft, object); },
                    bodies};
  }
  const WorldPairs pairs = pairs_of(gate);
  crossings.run([&](CrossingPrevention& prevention) {
    std::vector<btSoftBody*> wanted;
    std::copy_if(bodies.begin(), bodies.end(), std::back_inserter(wanted), is_wanted);
    prevention.run({wanted.data(), wanted.size()}, std::cref(pairs), time_step, surroundings, released(),
                   &massless_paths);
  });
  if (crossings.get() != nullptr) read_out.add_crossings(crossings.get()->impulses(), bodies);
}

void WorldQueries::read_contacts(Span<btSoftBody* const> bodies, btBroadphaseInterface& broadphase_of_bodies) {
  const auto notes_of = [](const auto& guarded) -> const ContactNotes& {
    static const ContactNotes none;
    return guarded.get() != nullptr ? guarded.get()->notes() : none;
  };
  read_out.read(bodies, broadphase_of_bodies, {notes_of(contacts), notes_of(rigid_meshes), notes_of(convex_shapes)});
}

}  // namespace softcd::bullet

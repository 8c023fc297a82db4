#include "worlds/attached_deformable_world.hpp"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

namespace softcd::bullet {

/// Moves nodes back to the start of the step, after Bullet has moved them. Its destructor moves them to their new ends,
/// m_q. Nodes that something has put elsewhere since then go back there: nodes on anchors, and those that actions of
/// the app have moved.
class AttachedDeformableWorld::NodesPutBack {
 public:
  /// `has_integrated` says that Bullet has moved all nodes, even if resting nodes have not changed.
  NodesPutBack(std::vector<Way>& ways, bool has_integrated) : ways_(ways), has_moved_(has_integrated) {
    for (Way& way : ways_) {
      for (int i = 0; i < way.body->m_nodes.size(); ++i) {
        btSoftBody::Node& node = way.body->m_nodes[i];
        const auto index = static_cast<std::size_t>(i);
        way.are_placed[index] = node.m_x != node.m_q;
        way.ends[index] = std::exchange(node.m_x, way.starts[index]);
        has_moved_ = has_moved_ || node.m_x != way.ends[index];
      }
    }
  }
  ~NodesPutBack() {
    for (const Way& way : ways_) {
      for (int i = 0; i < way.body->m_nodes.size(); ++i) {
        btSoftBody::Node& node = way.body->m_nodes[i];
        const auto index = static_cast<std::size_t>(i);
        node.m_x = has_moved_ && !way.are_placed[index] ? node.m_q : way.ends[index];
        node.m_vn = node.m_v;
      }
    }
  }
  NodesPutBack(const NodesPutBack&) = delete;
  NodesPutBack& operator=(const NodesPutBack&) = delete;

  /// Returns false if no node has moved: an exception may have left the step before.
  bool has_moved() const { return has_moved_; }

 private:
  std::vector<Way>& ways_;
  bool has_moved_;
};

AttachedDeformableWorld::AttachedDeformableWorld(btDeformableMultiBodyDynamicsWorld& world, const Settings& settings)
    : AttachedWorld(world, world.getSoftBodyArray(), kDeformableWorld, settings),
      solver_callback_(world, call_solver_callback) {
  world.addAction(this);
}

Span<const Limitation> AttachedDeformableWorld::limitations() const {
  static constexpr Limitation kLimitations[] = {
      kTreesLimitation,
      kRigidMeshesLimitation,
  };
  return {kLimitations, std::size(kLimitations) - (sees_pairs() ? 1 : 0)};
}

void AttachedDeformableWorld::prepare_solver() {
  step().find_soft_contacts();
  step().before_solver();
  hidden_.clear();  // of a step that an exception has left
  solver_callback_.stand();
  solver_calls_ = 0;
  has_responded_ = false;
  face_trees().take(bodies());
  keep_starts();
}

void AttachedDeformableWorld::call_solver_callback(btScalar time, btDeformableMultiBodyDynamicsWorld* world) {
  auto* const attached = static_cast<AttachedDeformableWorld*>(AttachedWorld::of(*world));
  if (attached == nullptr) return;
  if (const auto apps = attached->solver_callback_.apps()) apps(time, world);
  if (attached->is_solved() && ++attached->solver_calls_ == 2) attached->after_solver();
}

/// Responds to contacts between soft bodies in Bullet's place, which would not find that nodes pass through faces.
void AttachedDeformableWorld::after_solver() {
  const Span<btSoftBody* const> all = bodies();
  queries().read_out.keep_contacts_of_new_sleepers(all, *world().getBroadphase());
  try {
    hidden_.reserve(all.size());
  } catch (const std::bad_alloc&) {
    return;
  }
  step().respond(step_length());
  has_responded_ = true;
  for (btSoftBody* body : all) {
    hidden_.push_back({body, body->m_faceNodeContacts.size()});
    body->m_faceNodeContacts.resizeNoInitialize(0);
  }
}

/// The entries are still there, unless Bullet has written others.
void AttachedDeformableWorld::show_soft_contacts() {
  const Span<btSoftBody* const> all = bodies();
  for (const HiddenContacts& hidden : hidden_) {
    const bool is_there = std::find(all.begin(), all.end(), hidden.body) != all.end();
    if (!is_there || hidden.body->m_faceNodeContacts.size() > 0) continue;
    hidden.body->m_faceNodeContacts.resizeNoInitialize(hidden.count);
  }
  hidden_.clear();
}

/// Bullet calls actions after it has integrated all bodies.
void AttachedDeformableWorld::updateAction(btCollisionWorld* /*world*/, btScalar /*time_step*/) {
  has_integrated_ = true;
  finish_step();
  has_integrated_ = false;
}

void AttachedDeformableWorld::keep_starts() {
  has_integrated_ = false;
  ways_.clear();
  queries().crossings.run([&](CrossingPrevention&) {
    for (btSoftBody* body : bodies()) {
      if (!queries().may_change(*body)) continue;
      const std::vector<btVector3> starts = values_of(*body, &btSoftBody::Node::m_x);
      ways_.push_back({body, starts, /*ends=*/starts, std::vector<bool>(starts.size())});
    }
  });
}

void AttachedDeformableWorld::end_step(btScalar time_step) {
  face_trees().give_back();
  show_soft_contacts();
  if (!has_responded_) queries().read_out.take_rigid_impulses(bodies());
  prevent_crossings(time_step);
  step().end_paths();
  refit_face_trees(bodies());
  step().end();
}

/// The app's actions, called before, may have changed and removed bodies.
void AttachedDeformableWorld::prevent_crossings(btScalar time_step) {
  const Span<btSoftBody* const> all = bodies();
  const auto is_lost = [&](const Way& way) {
    const bool is_there = std::find(all.begin(), all.end(), way.body) != all.end();
    return !is_there || static_cast<std::size_t>(way.body->m_nodes.size()) != way.starts.size();
  };
  ways_.erase(std::remove_if(ways_.begin(), ways_.end(), is_lost), ways_.end());
  const NodesPutBack put_back(ways_, has_integrated_);
  if (!put_back.has_moved()) return;
  queries().mirror.resume_step(all);
  step().prevent_crossings(time_step);
}

void AttachedDeformableWorld::remove_hooks() {
  AttachedWorld::remove_hooks();
  solver_callback_.give_back();
  world().removeAction(this);
}

void AttachedDeformableWorld::after_ray_test() noexcept {
  if (is_solved()) face_trees().take(bodies());
}

}  // namespace softcd::bullet

#include "bodies/massless_node_paths.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "BulletSoftBody/btDeformableBodySolver.h"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;

bool is_massless(const Node& node) {
  return !(node.m_im > 0);
}

/// Returns whether Bullet integrates the body implicitly. It then sets m_q to m_x, adds gravity to m_v, and moves the
/// node by m_vn.
bool is_implicit(const btSoftBody& body) {
  const auto* solver = dynamic_cast<const btDeformableBodySolver*>(body.getSoftBodySolver());
  return solver != nullptr && solver->m_objective->m_implicit;
}

/// Returns whether two values differ by the rounding of values as large as `b` and `size` only.
bool are_same(const btVector3& a, const btVector3& b, btScalar size) {
  return a.distance(b) <= 8 * SIMD_EPSILON * (b.length() + size);
}

/// Replaces the velocity of the node's path by the node's own, damped if Bullet's solver has damped the other one. Does
/// nothing if the app has given the node a third one. `size` is that of the values of which velocities are differences.
void replace_velocity(Node& node, const btVector3& of_path, const btVector3& own, btScalar damping, btScalar size) {
  for (const btScalar rest : {btScalar(1), 1 - damping}) {
    if (!are_same(node.m_v, rest * of_path, size)) continue;
    node.m_v = node.m_vn = rest * own;
    return;
  }
}

}  // namespace

const MasslessNodePaths::Track* MasslessNodePaths::find(const btSoftBody& body) const {
  const auto found = tracks_.find(BodyKey(body));
  if (found == tracks_.end()) return nullptr;
  return found->second.node_count == body.m_nodes.size() ? &found->second : nullptr;
}

btScalar MasslessNodePaths::steps_per_second(const btSoftBody& body) const {
  return begins_at_nodes() ? 1 / time_step_ : body.m_sst.isdt;  // scaled by Config::timescale
}

btVector3 MasslessNodePaths::velocity_of(const Path& path, const btSoftBody& body) const {
  btVector3 velocity = (path.own_end - path.end) * steps_per_second(body);
  if (!begins_at_nodes()) return velocity;
  const btScalar fastest = body.m_worldInfo->m_maxDisplacement * steps_per_second(body);
  for (int axis = 0; axis < 3; ++axis) btClamp(velocity[axis], -fastest, fastest);  // as Bullet does
  return velocity;
}

void MasslessNodePaths::begin_step(Span<btSoftBody* const> bodies) {
  end_paths(bodies);
  has_moves_ = false;
}

bool MasslessNodePaths::has_moved(const btSoftBody& body, const Track& track) const {
  const auto is_there = [&](const Path& path) { return body.m_nodes[path.node].m_x == path.end; };
  if (std::all_of(track.paths.begin(), track.paths.end(), is_there)) return false;
  btScalar farthest = 0;
  for (const Path& path : track.paths) {
    const Node& node = body.m_nodes[path.node];
    if (node.m_q != path.start) return false;
    farthest = btMax(farthest, node.m_x.distance(path.end));
  }
  if (begins_at_nodes() && farthest > body.m_worldInfo->m_maxDisplacement) return false;
  return farthest <= body.m_bounds[0].distance(body.m_bounds[1]);
}

void MasslessNodePaths::find_moves(Span<btSoftBody* const> bodies) {
  if (!std::exchange(are_ends_known_, false) || tracks_.empty()) return;
  for (const btSoftBody* body : bodies) {
    Track* const track = find(*body);
    if (track == nullptr) continue;
    track->has_moved = has_moved(*body, *track);
    has_moves_ |= track->has_moved;
  }
}

void MasslessNodePaths::set_starts(Span<btSoftBody* const> bodies, btScalar time_step) {
  if (!std::exchange(has_moves_, false)) return;
  time_step_ = time_step;
  for (btSoftBody* body : bodies) {
    Track* const track = find(*body);
    if (track == nullptr || !track->has_moved || !body->isActive()) continue;  // sleeping bodies have no prediction
    const bool begins_with_last_velocity = is_implicit(*body);
    for (Path& path : track->paths) {
      Node& node = body->m_nodes[path.node];
      if (node.*ends_.start == path.end || !is_massless(node)) continue;
      if (begins_with_last_velocity) {
        node.m_v = node.m_vn;
        node.m_q = node.m_x + node.m_v / steps_per_second(*body);
      }
      path.own_start = std::exchange(node.*ends_.start, path.end);
      path.own_end = node.*ends_.end;
      path.own_velocity = node.m_v;
      node.m_v = node.m_vn = velocity_of(path, *body);
      path.is_changed = has_changes_ = true;
    }
    if (!begins_at_nodes()) continue;
    body->updateNormals();
    body->updateBounds();
  }
}

void MasslessNodePaths::round_ends(btSoftBody& body) const {
  const Track* const track = has_changes_ ? find(body) : nullptr;
  if (track == nullptr) return;
  for (const Path& path : track->paths) {
    if (!path.is_changed) continue;
    btVector3& end = body.m_nodes[path.node].*ends_.end;
    if (are_same(end, path.own_end, path.end.length())) end = path.own_end;
  }
}

void MasslessNodePaths::end_paths(Span<btSoftBody* const> bodies) {
  if (!std::exchange(has_changes_, false)) return;
  for (btSoftBody* body : bodies) {
    Track* const track = find(*body);
    if (track == nullptr) continue;
    for (Path& path : track->paths) {
      if (!std::exchange(path.is_changed, false)) continue;
      Node& node = body->m_nodes[path.node];
      if (begins_at_nodes()) {
        if (are_same(node.m_x, path.own_end, path.end.length())) {
          node.m_x = node.m_q = path.own_end;
        } else if (node.m_x == path.end) {
          node.m_x = path.own_start;
        }
      }
      const btScalar size = node.m_x.length() * steps_per_second(*body);
      replace_velocity(node, velocity_of(path, *body), path.own_velocity, body->m_cfg.kDP, size);
    }
  }
}

void MasslessNodePaths::take_starts_back(Span<btSoftBody* const> bodies) {
  if (!has_changes_) return;
  for (btSoftBody* body : bodies) {
    const Track* const track = find(*body);
    if (track == nullptr) continue;
    for (const Path& path : track->paths) {
      if (path.is_changed) body->m_nodes[path.node].*ends_.start = path.own_start;
    }
  }
  end_paths(bodies);
}

void MasslessNodePaths::end_step(Span<btSoftBody* const> bodies) {
  are_ends_known_ = false;
  try {
    for (const btSoftBody* body : bodies) {
      const Span<const Node> nodes = span_of(body->m_nodes);
      const auto first = std::find_if(nodes.begin(), nodes.end(), is_massless);
      if (first == nodes.end() || body->m_reducedModel) continue;  // Bullet places the nodes of reduced models itself
      Track& track = tracks_[BodyKey(*body)];
      track.node_count = body->m_nodes.size();
      std::size_t count = 0;
      for (auto i = static_cast<int>(first - nodes.begin()); i < track.node_count; ++i) {
        const Node& node = body->m_nodes[i];
        if (!is_massless(node)) continue;
        if (count == track.paths.size()) track.paths.emplace_back();
        Path& path = track.paths[count++];
        path.node = i;
        path.end = node.m_x;
        path.start = node.m_q;
        path.is_changed = false;
      }
      track.paths.resize(count);
      track.is_present = true;
    }
  } catch (...) {
    tracks_.clear();
    throw;
  }
  for (auto track = tracks_.begin(); track != tracks_.end();) {
    track = std::exchange(track->second.is_present, false) ? std::next(track) : tracks_.erase(track);
  }
  are_ends_known_ = true;
}

}  // namespace softcd::bullet

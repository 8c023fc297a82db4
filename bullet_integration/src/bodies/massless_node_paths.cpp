#include "bodies/massless_node_paths.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;

bool is_massless(const Node& node) {
  return !(node.m_im > 0);
}

/// Returns whether two velocities of a node differ by the rounding of its place only.
bool are_same(const btVector3& a, const btVector3& b, const Node& node, btScalar steps_per_second) {
  const btScalar rounding = 8 * SIMD_EPSILON * (b.length() + node.m_x.length() * steps_per_second);
  return a.distance(b) <= rounding;
}

/// Replaces the velocity of the node's path by the node's own, damped if Bullet's solver has damped the other one. Does
/// nothing if the app has given the node a third one.
void replace_velocity(Node& node, const btVector3& of_path, const btVector3& own, const btSoftBody& body) {
  for (const btScalar rest : {btScalar(1), 1 - body.m_cfg.kDP}) {
    if (!are_same(node.m_v, rest * of_path, node, body.m_sst.isdt)) continue;
    node.m_v = rest * own;
    return;
  }
}

}  // namespace

MasslessNodePaths::Track* MasslessNodePaths::find(const btSoftBody& body) {
  const auto found = tracks_.find(BodyKey(body));
  if (found == tracks_.end()) return nullptr;
  return found->second.node_count == body.m_nodes.size() ? &found->second : nullptr;
}

void MasslessNodePaths::begin_step(Span<btSoftBody* const> bodies) {
  give_velocities_back(bodies);
  has_moves_ = false;
}

bool MasslessNodePaths::has_moved(const btSoftBody& body, const Track& track) {
  btScalar farthest = 0;
  for (const Path& path : track.paths) {
    const Node& node = body.m_nodes[path.node];
    if (node.m_q != path.start) return false;
    farthest = btMax(farthest, node.m_x.distance(path.end));
  }
  return farthest > 0 && farthest <= body.m_bounds[0].distance(body.m_bounds[1]);
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

void MasslessNodePaths::set_starts(Span<btSoftBody* const> bodies) {
  if (!std::exchange(has_moves_, false)) return;
  for (btSoftBody* body : bodies) {
    Track* const track = find(*body);
    if (track == nullptr || !track->has_moved || !body->isActive()) continue;  // sleeping bodies have no prediction
    for (Path& path : track->paths) {
      Node& node = body->m_nodes[path.node];
      if (node.m_q == path.end || !is_massless(node)) continue;
      path.own_start = std::exchange(node.m_q, path.end);
      path.own_velocity = node.m_v;
      node.m_v = (node.m_x - path.end) * body->m_sst.isdt;
      path.is_changed = has_changes_ = true;
    }
  }
}

void MasslessNodePaths::give_velocities_back(Span<btSoftBody* const> bodies) {
  if (!std::exchange(has_changes_, false)) return;
  for (btSoftBody* body : bodies) {
    Track* const track = find(*body);
    if (track == nullptr) continue;
    for (Path& path : track->paths) {
      if (!std::exchange(path.is_changed, false)) continue;
      const btVector3 end = path.own_start + path.own_velocity * body->m_sst.sdt;
      replace_velocity(body->m_nodes[path.node], (end - path.end) * body->m_sst.isdt, path.own_velocity, *body);
    }
  }
}

void MasslessNodePaths::take_starts_back(Span<btSoftBody* const> bodies) {
  if (!has_changes_) return;
  for (btSoftBody* body : bodies) {
    const Track* const track = find(*body);
    if (track == nullptr) continue;
    for (const Path& path : track->paths) {
      if (path.is_changed) body->m_nodes[path.node].m_q = path.own_start;
    }
  }
  give_velocities_back(bodies);
}

void MasslessNodePaths::end_step(Span<btSoftBody* const> bodies) {
  are_ends_known_ = false;
  try {
    for (const btSoftBody* body : bodies) {
      const Span<const Node> nodes = span_of(body->m_nodes);
      if (std::none_of(nodes.begin(), nodes.end(), is_massless)) continue;
      Track& track = tracks_[BodyKey(*body)];
      track.paths.clear();
      track.node_count = body->m_nodes.size();
      for (int i = 0; i < track.node_count; ++i) {
        const Node& node = body->m_nodes[i];
        if (is_massless(node)) track.paths.push_back({i, node.m_x, node.m_q});
      }
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

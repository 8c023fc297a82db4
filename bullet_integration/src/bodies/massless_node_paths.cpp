#include "bodies/massless_node_paths.hpp"

#include <algorithm>
#include <utility>

#include "bodies/bounds.hpp"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;

bool is_massless(const Node& node) {
  return !(node.m_im > 0);
}

btScalar size_of(const std::vector<btVector3>& places) {
  Bounds bounds = {places.front(), places.front()};
  for (const btVector3& place : places) bounds.add(place);
  return bounds.low.distance(bounds.high);
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
  return found->second.ends.size() == static_cast<std::size_t>(body.m_nodes.size()) ? &found->second : nullptr;
}

void MasslessNodePaths::begin_step(Span<btSoftBody* const> bodies) {
  give_velocities_back(bodies);
  has_begun_ = true;
}

bool MasslessNodePaths::has_moved_massless_nodes_alone(const btSoftBody& body, const Track& track) {
  btScalar farthest = 0;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const Node& node = body.m_nodes[i];
    const btVector3& end = track.ends[static_cast<std::size_t>(i)];
    if (node.m_q == end) continue;
    if (!is_massless(node)) return false;
    farthest = btMax(farthest, node.m_q.distance(end));
  }
  return farthest > 0 && farthest <= size_of(track.ends);
}

void MasslessNodePaths::set_starts(Span<btSoftBody* const> bodies) {
  if (!std::exchange(has_begun_, false) || !std::exchange(are_ends_known_, false)) return;
  for (btSoftBody* body : bodies) {
    if (tracks_.empty() || !body->isActive()) continue;  // Bullet has not predicted sleeping bodies
    Track* const track = find(*body);
    if (track == nullptr || !has_moved_massless_nodes_alone(*body, *track)) continue;
    for (int i = 0; i < body->m_nodes.size(); ++i) {
      Node& node = body->m_nodes[i];
      const btVector3& end = track->ends[static_cast<std::size_t>(i)];
      if (node.m_q == end || track->lent.size() == track->lent.capacity()) continue;
      track->lent.push_back({i, node.m_q, node.m_v});
      node.m_q = end;
      node.m_v = (node.m_x - node.m_q) * body->m_sst.isdt;
      has_lent_ = true;
    }
  }
}

void MasslessNodePaths::give_velocities_back(Span<btSoftBody* const> bodies) {
  if (!std::exchange(has_lent_, false)) return;
  for (btSoftBody* body : bodies) {
    Track* const track = find(*body);
    if (track == nullptr) continue;
    for (const Lent& lent : track->lent) {
      Node& node = body->m_nodes[lent.node];
      const btVector3 end = lent.place + lent.velocity * body->m_sst.sdt;
      const btVector3 velocity = (end - track->ends[static_cast<std::size_t>(lent.node)]) * body->m_sst.isdt;
      replace_velocity(node, velocity, lent.velocity, *body);
    }
    track->lent.clear();
  }
}

void MasslessNodePaths::take_starts_back(Span<btSoftBody* const> bodies) {
  if (!has_lent_) return;
  for (btSoftBody* body : bodies) {
    const Track* const track = find(*body);
    if (track == nullptr) continue;
    for (const Lent& lent : track->lent) body->m_nodes[lent.node].m_q = lent.place;
  }
  give_velocities_back(bodies);
}

void MasslessNodePaths::end_step(Span<btSoftBody* const> bodies) {
  are_ends_known_ = false;
  try {
    for (const btSoftBody* body : bodies) {
      const Span<const Node> nodes = span_of(body->m_nodes);
      const auto massless = std::count_if(nodes.begin(), nodes.end(), is_massless);
      if (massless == 0) continue;
      Track& track = tracks_[BodyKey(*body)];
      track.ends.clear();
      track.ends.reserve(nodes.size());
      for (const Node& node : nodes) track.ends.push_back(node.m_x);
      track.lent.clear();
      track.lent.reserve(static_cast<std::size_t>(massless));
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

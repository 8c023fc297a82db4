#include "crossings/way_out.hpp"

#include "bodies/inverse_mass.hpp"

namespace softcd::bullet {
namespace {

/// A way changes what others have done, so that they are passed through several times.
constexpr int kSweeps = 4;

}  // namespace

void NodesOnWaysOut::hold_anchored(const btSoftBody& body) {
  if (!seen_.insert(&body).second) return;
  for (int a = 0; a < body.m_anchors.size(); ++a) anchored_.insert(body.m_anchors[a].m_node);
  for (int a = 0; a < body.m_deformableAnchors.size(); ++a) anchored_.insert(body.m_deformableAnchors[a].m_node);
}

/// Returns false if the app has removed a body or nodes since the way was found.
bool NodesOnWaysOut::look_up(const WayOut& way) {
  moved_.clear();
  for (const WayOut::End& end : way.ends) {
    const WorldMirror::Member* const member = mirror_.find(end.body);
    if (member == nullptr || end.node >= static_cast<std::uint32_t>(member->body->m_nodes.size())) return false;
    btSoftBody& body = *member->body;
    hold_anchored(body);
    btSoftBody::Node& node = body.m_nodes[static_cast<int>(end.node)];
    const bool is_held = !body.isActive() || anchored_.count(&node) > 0;
    moved_.push_back({&node, end.direction, node.*start_of(kind_.ends, body), is_held ? btScalar(0) : node.m_im});
  }
  return true;
}

void NodesOnWaysOut::move(const std::vector<WayOut>& ways, btScalar greatest_shift, btScalar time_step) {
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (const WayOut& way : ways) {
      if (!look_up(way)) continue;
      ContactInverseMass inverse_mass;
      btScalar gone = 0;
      btScalar speed = 0;
      btScalar most = 0;
      for (const Moved& moved : moved_) {
        const btScalar weight = moved.direction.length();
        inverse_mass.add(weight, moved.inverse_mass);
        most = btMax(most, weight * moved.inverse_mass);
        gone += moved.direction.dot(moved.node->*kind_.ends.end - moved.start);
        speed += moved.direction.dot(moved.node->m_v);
      }
      if (!(most > 0)) continue;
      const btScalar goal = btMin(way.distance, greatest_shift * inverse_mass.value() / most);
      const btScalar impulse = btMax(btScalar(0), -speed) / inverse_mass.value();
      const btScalar push = (goal - gone) / inverse_mass.value() - impulse * time_step;
      const btScalar shift = btClamped(push, btScalar(0), greatest_shift / most);
      if (!(impulse > 0) && !(shift > 0)) continue;
      for (const Moved& moved : moved_) {
        const btVector3 share = moved.direction * moved.inverse_mass;
        kind_.push(*moved.node, impulse * share, shift * share, time_step);
      }
    }
  }
}

}  // namespace softcd::bullet

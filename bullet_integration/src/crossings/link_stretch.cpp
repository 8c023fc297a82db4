#include "crossings/link_stretch.hpp"

#include <cstddef>

#include "native/arrays.hpp"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;

/// Greatest length that responses may give a link, in rest lengths. Links of bodies that are not caught are shorter, so
/// that they cost one comparison.
constexpr btScalar kMostStretch = 2;
/// A link that is longer than its limit by a smaller share is left as it is.
constexpr btScalar kNegligibleShare = btScalar(1e-3);

bool limit_stretch_of(btSoftBody& body, const NodeStates& before, btScalar time_step) {
  const auto solved_end = [&](const Node& node) {
    return before.ends[static_cast<std::size_t>(&node - &body.m_nodes[0])];
  };
  bool has_changed = false;
  for (const btSoftBody::Link& link : span_of(body.m_links)) {
    Node &a = *link.m_n[0], &b = *link.m_n[1];
    const btVector3 start = b.m_q - a.m_q;
    const btVector3 end = start + time_step * (b.m_v - a.m_v);
    const btScalar usual = kMostStretch * link.m_rl;
    if (!(end.length2() > usual * usual)) continue;
    const btScalar limit = btMax(usual, btMax(start.length(), (solved_end(b) - solved_end(a)).length()));
    const btScalar length = end.length();
    const btScalar inverse_mass = a.m_im + b.m_im;
    if (!(length > (1 + kNegligibleShare) * limit) || !(inverse_mass > 0)) continue;
    const btVector3 impulse = ((length - limit) / (length * time_step * inverse_mass)) * end;
    a.m_v += a.m_im * impulse;
    b.m_v -= b.m_im * impulse;
    has_changed = true;
  }
  return has_changed;
}

}  // namespace

bool limit_stretch(const AnsweredBodies& answered, btScalar time_step) {
  bool has_changed = false;
  for (const auto& [body, before] : answered) has_changed |= limit_stretch_of(*body, before, time_step);
  return has_changed;
}

}  // namespace softcd::bullet

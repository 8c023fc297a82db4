#include "crossings/crossing_impulses.hpp"

#include <algorithm>

namespace softcd::bullet {
namespace {

void add_once(std::vector<const btCollisionObject*>& objects, const btCollisionObject* object) {
  if (std::find(objects.begin(), objects.end(), object) == objects.end()) objects.push_back(object);
}

}  // namespace

void CrossingImpulses::clear() {
  others_.clear();
  impulses_.clear();
}

void CrossingImpulses::add(const btSoftBody::Node& node, const btCollisionObject& other) {
  add_once(others_[&node], &other);
}

CrossingImpulses::Objects CrossingImpulses::all_others(const btSoftBody& body) const {
  Objects all;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const auto known = others_.find(&body.m_nodes[i]);
    if (known == others_.end()) continue;
    for (const btCollisionObject* other : known->second) add_once(all, other);
  }
  return all;
}

void CrossingImpulses::measure(const CrossingsOfKind& kind, const AnsweredBodies& answered, btScalar time_step) {
  for (const auto& [body, before] : answered) {
    const Objects all = all_others(*body);
    std::vector<btVector3> sums(all.size(), btVector3(0, 0, 0));
    for (int i = 0; i < body->m_nodes.size(); ++i) {
      const btSoftBody::Node& node = body->m_nodes[i];
      const btVector3 change = kind.velocity_change(node, before, static_cast<std::size_t>(i), time_step);
      if (!(node.m_im > 0) || change.isZero()) continue;
      // A node without an impact was held together with its whole body.
      const auto known = others_.find(&node);
      const Objects& others = known != others_.end() ? known->second : all;
      for (const btCollisionObject* other : others) {
        const auto place = std::find(all.begin(), all.end(), other) - all.begin();
        sums[static_cast<std::size_t>(place)] += change / (node.m_im * btScalar(others.size()));
      }
    }
    for (std::size_t i = 0; i < all.size(); ++i) impulses_.push_back({body, all[i], sums[i]});
  }
}

}  // namespace softcd::bullet

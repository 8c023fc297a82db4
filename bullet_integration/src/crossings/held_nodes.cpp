#include "crossings/held_nodes.hpp"

namespace softcd::bullet {

bool HeldNodes::add(btSoftBody::Node& node) {
  return !is_moved_by_others(node, constrained_.find(node)) && nodes_.insert(&node).second;
}

bool HeldNodes::add(const std::vector<Impact>& impacts) {
  bool has_added = false;
  for (const Impact& impact : impacts) {
    for (btSoftBody::Node* node : impact.nodes) has_added |= add(*node);
  }
  return has_added;
}

bool HeldNodes::add_bodies(const std::vector<Impact>& impacts) {
  bool has_added = false;
  for (const Impact& impact : impacts) {
    for (btSoftBody* body : impact.bodies) {
      for (int i = 0; i < body->m_nodes.size(); ++i) has_added |= add(body->m_nodes[i]);
    }
  }
  return has_added;
}

void HeldNodes::put_back() const {
  for (btSoftBody::Node* node : nodes_) kind_.hold(*node);
}

}  // namespace softcd::bullet

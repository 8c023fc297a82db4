#include "native_touches.hpp"

#include <algorithm>
#include <tuple>

namespace softcd::bullet {
namespace {

/// Keeps the order of the others.
template <class RigidContact>
void remove_at(btAlignedObjectArray<RigidContact>& contacts, int index) {
  for (int i = index; i + 1 < contacts.size(); ++i) contacts.swap(i, i + 1);
  contacts.pop_back();
}

}  // namespace

void NativeTouches::clear() {
  entries_.clear();
  doubted_.clear();
}

template <class RigidContact>
void NativeTouches::add(btSoftBody& body, Array array, int index, const void* feature, const RigidContact& contact) {
  entries_.emplace(Key(feature, contact.m_cti.m_colObj), Entry{&body, array, index, contact.m_cti.m_normal});
}

void NativeTouches::read(btSoftBody& body) {
  for (int i = 0; i < body.m_rcontacts.size(); ++i) {
    add(body, Array::classic_node, i, body.m_rcontacts[i].m_node, body.m_rcontacts[i]);
  }
  for (int i = 0; i < body.m_nodeRigidContacts.size(); ++i) {
    add(body, Array::node, i, body.m_nodeRigidContacts[i].m_node, body.m_nodeRigidContacts[i]);
  }
  for (int i = 0; i < body.m_faceRigidContacts.size(); ++i) {
    add(body, Array::face, i, body.m_faceRigidContacts[i].m_face, body.m_faceRigidContacts[i]);
  }
}

bool NativeTouches::has_within(const void* feature, const RigidTouch& touch, btScalar least_cosine) const {
  const auto [begin, end] = entries_.equal_range(Key(feature, touch.object));
  return std::any_of(begin, end,
                     [&](const auto& entry) { return entry.second.normal.dot(touch.normal) > least_cosine; });
}

bool NativeTouches::hold(const btSoftBody::Node& node, const RigidTouch& touch) const {
  return has_within(&node, touch, 0);
}

bool NativeTouches::hold(const btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch) const {
  constexpr btScalar kNearlySame = btScalar(0.9);  // 26 degrees
  if (has_within(&face, touch, 0)) return true;
  for (int i = 0; i < 3; ++i) {
    if (weights[i] > kLeastWeight && !has_within(face.m_n[i], touch, kNearlySame)) return false;
  }
  return true;
}

void NativeTouches::doubt(const void* feature, const btCollisionObject& object) {
  const auto [begin, end] = entries_.equal_range(Key(feature, &object));
  for (auto entry = begin; entry != end; ++entry) doubted_.push_back(entry->second);
}

void NativeTouches::remove_doubted() {
  const auto place = [](const Entry& entry) { return std::tuple(entry.body, entry.array, entry.index); };
  std::sort(doubted_.begin(), doubted_.end(), [&](const Entry& a, const Entry& b) { return place(a) > place(b); });
  const auto end = std::unique(doubted_.begin(), doubted_.end(),
                               [&](const Entry& a, const Entry& b) { return place(a) == place(b); });
  for (auto entry = doubted_.begin(); entry != end; ++entry) {
    switch (entry->array) {
      case Array::classic_node:
        remove_at(entry->body->m_rcontacts, entry->index);
        break;
      case Array::node:
        remove_at(entry->body->m_nodeRigidContacts, entry->index);
        break;
      case Array::face:
        remove_at(entry->body->m_faceRigidContacts, entry->index);
        break;
    }
  }
  clear();
}

}  // namespace softcd::bullet

#include "rigid/native_touches.hpp"

#include <algorithm>
#include <tuple>

namespace softcd::bullet {
namespace {

/// Removes one contact and keeps the order of the others.
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

/// `feature` is the contact's member that points to the node or the face.
template <class RigidContacts, class Feature>
void NativeTouches::add(btSoftBody& body, const RigidContacts& contacts, Feature feature, bool is_classic) {
  for (int i = 0; i < contacts.size(); ++i) {
    const auto& info = contacts[i].m_cti;
    entries_.emplace(Key(contacts[i].*feature, info.m_colObj), Entry{&body, is_classic, i, info.m_normal});
  }
}

void NativeTouches::read(btSoftBody& body) {
  add(body, body.m_rcontacts, &btSoftBody::RContact::m_node, /*is_classic=*/true);
  add(body, body.m_nodeRigidContacts, &btSoftBody::DeformableNodeRigidContact::m_node, /*is_classic=*/false);
  add(body, body.m_faceRigidContacts, &btSoftBody::DeformableFaceRigidContact::m_face, /*is_classic=*/false);
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

void NativeTouches::doubt(const btSoftBody::Node& node, const btCollisionObject& object) {
  const auto [begin, end] = entries_.equal_range(Key(&node, &object));
  for (auto entry = begin; entry != end; ++entry) {
    if (entry->second.is_classic) doubted_.push_back(entry->second);
  }
}

void NativeTouches::remove_doubted() {
  const auto place = [](const Entry& entry) { return std::tuple(entry.body, entry.index); };
  std::sort(doubted_.begin(), doubted_.end(), [&](const Entry& a, const Entry& b) { return place(a) > place(b); });
  const auto end = std::unique(doubted_.begin(), doubted_.end(),
                               [&](const Entry& a, const Entry& b) { return place(a) == place(b); });
  for (auto entry = doubted_.begin(); entry != end; ++entry) remove_at(entry->body->m_rcontacts, entry->index);
  clear();
}

}  // namespace softcd::bullet

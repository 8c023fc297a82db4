#include "tangled_pairs.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>

#include "tangles.hpp"

namespace softcd::bullet {
namespace {

constexpr std::size_t kMostNamed = 8;

auto feature_of(const Contact& contact) {
  const std::uint32_t(&v)[4] = contact.vertices;
  return std::make_tuple(contact.kind, contact.body_a.value, v[0], v[1], v[2], v[3]);
}

bool is_still_tangled(const Contact& contact, const WorldMirror& mirror, const WorldKind& kind) {
  const auto known = [&mirror](BodyId id) {
    const WorldMirror::Member* const member = mirror.find(id);
    return member != nullptr && mirror.has(*member->body) && !member->topology_changed ? member : nullptr;
  };
  const WorldMirror::Member* const a = known(contact.body_a);
  const WorldMirror::Member* const b = known(contact.body_b);
  return a != nullptr && b != nullptr && is_tangled(MemberContact{contact, *a, *b}, kind);
}

/// In the order of their keys, each once.
void keep_tangled(std::vector<Contact>& contacts, const WorldMirror& mirror, const WorldKind& kind) {
  const auto is_before = [](const Contact& a, const Contact& b) { return feature_of(a) < feature_of(b); };
  const auto is_same = [](const Contact& a, const Contact& b) { return feature_of(a) == feature_of(b); };
  std::sort(contacts.begin(), contacts.end(), is_before);
  contacts.erase(std::unique(contacts.begin(), contacts.end(), is_same), contacts.end());
  const auto is_apart = [&](const Contact& contact) { return !is_still_tangled(contact, mirror, kind); };
  contacts.erase(std::remove_if(contacts.begin(), contacts.end(), is_apart), contacts.end());
}

}  // namespace

void TangledPairs::begin_step(const WorldMirror& mirror, const WorldKind& kind) {
  for (auto pair = pairs_.begin(); pair != pairs_.end();) {
    keep_tangled(pair->second.contacts, mirror, kind);
    pair->second.is_new = false;
    pair = pair->second.contacts.empty() ? pairs_.erase(pair) : std::next(pair);
  }
}

void TangledPairs::add(const Contact& found, TangleReason reason) {
  const auto ids = std::minmax(found.body_a.value, found.body_b.value);
  const auto pair = pairs_.try_emplace({ids.first, ids.second}, Features{reason}).first;
  pair->second.contacts.push_back(found);
}

std::string TangledPairs::describe_new(TangleReason reason, const WorldMirror& mirror,
                                       Span<btSoftBody* const> bodies) const {
  const auto number_of = [&](std::uint32_t id) {
    const auto* const position = std::find(bodies.begin(), bodies.end(), mirror.member(BodyId{id}).body);
    return std::to_string(position - bodies.begin());
  };
  std::string text;
  std::size_t count = 0;
  for (const auto& [ids, features] : pairs_) {
    if (!features.is_new || features.reason != reason || ++count > kMostNamed) continue;
    text += text.empty() ? "soft bodies " : ", ";
    text += number_of(ids.first);
    text += ids.first == ids.second ? " within itself" : " and " + number_of(ids.second);
  }
  if (count > kMostNamed) text += ", and " + std::to_string(count - kMostNamed) + " other pairs";
  return text;
}

}  // namespace softcd::bullet

#include "crossings/tangled_pairs.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "contacts/tangles.hpp"

namespace softcd::bullet {
namespace {

constexpr std::size_t kMostNamed = 8;
/// Name of a proxy body, which is none of the world's bodies.
constexpr const char* kObstacle = "a rigid mesh";

auto feature_of(const Contact& contact) {
  const std::uint32_t(&v)[4] = contact.vertices;
  return std::make_tuple(contact.kind, contact.body_a.value, v[0], v[1], v[2], v[3]);
}

/// Returns null if the body is not in this step.
const WorldMirror::Member* present(BodyId id, const WorldMirror& mirror) {
  const WorldMirror::Member* const member = mirror.find(id);
  return member != nullptr && mirror.has(*member->body) ? member : nullptr;
}

/// Returns whether both bodies are present and one has other faces than before. Its features then cannot be traced.
bool have_other_faces(BodyId id_a, BodyId id_b, const WorldMirror& mirror) {
  const WorldMirror::Member* const a = present(id_a, mirror);
  const WorldMirror::Member* const b = present(id_b, mirror);
  return a != nullptr && b != nullptr && (a->topology_changed || b->topology_changed);
}

bool is_still_tangled(const Contact& contact, const WorldMirror& mirror, const NodeEnds& ends) {
  const WorldMirror::Member* const a = present(contact.body_a, mirror);
  const WorldMirror::Member* const b = present(contact.body_b, mirror);
  return a != nullptr && b != nullptr && !a->topology_changed && !b->topology_changed &&
         is_tangled(MemberContact{contact, *a, *b}, ends);
}

/// Keeps the contacts that are still tangled, each feature pair once, sorted.
void keep_tangled(std::vector<Contact>& contacts, const WorldMirror& mirror, const NodeEnds& ends) {
  const auto is_before = [](const Contact& a, const Contact& b) { return feature_of(a) < feature_of(b); };
  const auto is_same = [](const Contact& a, const Contact& b) { return feature_of(a) == feature_of(b); };
  std::sort(contacts.begin(), contacts.end(), is_before);
  contacts.erase(std::unique(contacts.begin(), contacts.end(), is_same), contacts.end());
  const auto is_apart = [&](const Contact& contact) { return !is_still_tangled(contact, mirror, ends); };
  contacts.erase(std::remove_if(contacts.begin(), contacts.end(), is_apart), contacts.end());
}

}  // namespace

void TangledPairs::begin_step(const WorldMirror& mirror, const NodeEnds& ends) {
  for (auto pair = pairs_.begin(); pair != pairs_.end();) {
    std::vector<Contact>& contacts = pair->second.contacts;
    const bool waits_for_others =
        !contacts.empty() && have_other_faces({pair->first.first}, {pair->first.second}, mirror);
    keep_tangled(contacts, mirror, ends);
    pair->second.is_new = false;
    pair = contacts.empty() && !waits_for_others ? pairs_.erase(pair) : std::next(pair);
  }
  for (auto entry = times_.begin(); entry != times_.end();) {
    const auto [a, b] = entry->first;
    const bool exist = mirror.find(BodyId{a}) != nullptr && mirror.find(BodyId{b}) != nullptr;
    entry = exist ? std::next(entry) : times_.erase(entry);
  }
}

void TangledPairs::add(const Contact& found, TangleReason reason) {
  const Ids ids = std::minmax(found.body_a.value, found.body_b.value);
  auto pair = pairs_.find(ids);
  if (pair == pairs_.end()) pair = pairs_.emplace(ids, Features{reason, ++times_[ids]}).first;
  pair->second.contacts.push_back(found);
}

std::string TangledPairs::describe_new(TangleReason reason, const WorldMirror& mirror,
                                       Span<btSoftBody* const> bodies) const {
  const auto name_of = [&](std::uint32_t id) {
    const auto* const position = std::find(bodies.begin(), bodies.end(), mirror.member(BodyId{id}).body);
    return position != bodies.end() ? std::to_string(position - bodies.begin()) : kObstacle;
  };
  std::string text;
  std::size_t count = 0;
  for (const auto& [ids, features] : pairs_) {
    const bool is_described = (features.times & (features.times - 1)) == 0;  // a power of two
    if (!features.is_new || features.reason != reason || !is_described || ++count > kMostNamed) continue;
    text += text.empty() ? "soft bodies " : ", ";
    std::string first = name_of(ids.first);
    std::string second = name_of(ids.second);
    if (first == kObstacle) std::swap(first, second);
    text += first;
    text += ids.first == ids.second ? " within itself" : " and " + second;
    if (features.times > 1) text += " (" + std::to_string(features.times) + " times so far)";
  }
  if (count > kMostNamed) text += ", and " + std::to_string(count - kMostNamed) + " other pairs";
  return text;
}

}  // namespace softcd::bullet

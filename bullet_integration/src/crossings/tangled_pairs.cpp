#include "crossings/tangled_pairs.hpp"

#include <algorithm>
#include <utility>

namespace softcd::bullet {
namespace {

constexpr std::size_t kMostNamed = 8;
/// Name of a proxy body, which is none of the world's bodies.
constexpr const char* kObstacle = "a rigid mesh";
/// After this many steps without an addition a pair counts as separate. Bodies that keep parting and meeting do not
/// fill the log.
constexpr std::uint64_t kStepsApart = 64;

}  // namespace

void TangledPairs::begin_step() {
  ++step_;
  std::erase_if(pairs_, [this](const auto& entry) { return entry.second.last_step + kStepsApart < step_; });
}

void TangledPairs::add(const Contact& found, TangleReason reason) {
  const auto ids = std::minmax(found.body_a.value, found.body_b.value);
  pairs_.try_emplace({ids.first, ids.second}, Pair{reason, step_, step_}).first->second.last_step = step_;
}

std::string TangledPairs::describe_new(TangleReason reason, const WorldMirror& mirror,
                                       Span<btSoftBody* const> bodies) const {
  const auto name_of = [&](std::uint32_t id) {
    const auto* const position = std::find(bodies.begin(), bodies.end(), mirror.member(BodyId{id}).body);
    return position != bodies.end() ? std::to_string(position - bodies.begin()) : kObstacle;
  };
  std::string text;
  std::size_t count = 0;
  for (const auto& [ids, pair] : pairs_) {
    if (pair.first_step != step_ || pair.reason != reason || ++count > kMostNamed) continue;
    text += text.empty() ? "soft bodies " : ", ";
    std::string first = name_of(ids.first);
    std::string second = name_of(ids.second);
    if (first == kObstacle) std::swap(first, second);
    text += first;
    text += ids.first == ids.second ? " within itself" : " and " + second;
  }
  if (count > kMostNamed) text += ", and " + std::to_string(count - kMostNamed) + " other pairs";
  return text;
}

}  // namespace softcd::bullet

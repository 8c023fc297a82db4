#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "softcd/scene.hpp"

namespace softcd {

/// Pairs of bodies that somebody has listed.
class BodyPairList {
 public:
  BodyPairList() = default;
  explicit BodyPairList(Span<const BodyPair> pairs) {
    keys_.reserve(pairs.size());
    for (const BodyPair& pair : pairs) keys_.push_back(key(pair.a, pair.b));
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  }

  bool empty() const { return keys_.empty(); }
  /// In either order.
  bool has(BodyId a, BodyId b) const { return std::binary_search(keys_.begin(), keys_.end(), key(a, b)); }
  /// Each once.
  std::vector<BodyPair> pairs() const {
    std::vector<BodyPair> pairs;
    pairs.reserve(keys_.size());
    for (const std::uint64_t key : keys_) {
      pairs.push_back({{static_cast<std::uint32_t>(key >> 32)}, {static_cast<std::uint32_t>(key)}});
    }
    return pairs;
  }

 private:
  /// The lower id:32 | the higher:32 from high to low.
  static std::uint64_t key(BodyId a, BodyId b) {
    return (std::uint64_t{std::min(a, b).value} << 32) | std::max(a, b).value;
  }

  std::vector<std::uint64_t> keys_;
};

}  // namespace softcd

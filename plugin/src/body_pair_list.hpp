#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "softcd/scene.hpp"

namespace softcd {

/// A list of pairs of bodies that the caller has set.
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
  /// Returns whether the list has the pair, in either order.
  bool has(BodyId a, BodyId b) const { return std::binary_search(keys_.begin(), keys_.end(), key(a, b)); }
  /// Returns each pair once.
  std::vector<BodyPair> pairs() const {
    std::vector<BodyPair> pairs;
    pairs.reserve(keys_.size());
    for (const std::uint64_t key : keys_) {
      pairs.push_back({{static_cast<std::uint32_t>(key >> 32)}, {static_cast<std::uint32_t>(key)}});
    }
    return pairs;
  }

 private:
  /// Returns lower id:32 | higher id:32, from high to low bits.
  static std::uint64_t key(BodyId a, BodyId b) {
    return (std::uint64_t{std::min(a, b).value} << 32) | std::max(a, b).value;
  }

  std::vector<std::uint64_t> keys_;
};

}  // namespace softcd

#pragma once

#include <algorithm>
#include <utility>
#include <vector>

class btCollisionObject;
struct btDispatcherInfo;
class btOverlappingPairCache;

namespace softcd::bullet {

/// The order in which one thread comes upon a world's pairs. Several threads do in another one in every run.
class PairOrder {
 public:
  PairOrder(btOverlappingPairCache& pair_cache, const btDispatcherInfo& info) : pair_cache_(pair_cache), info_(info) {}

  /// Of two objects several pairs (of a compound's children) stay as they are: they are all of one thread. Throws
  /// nothing.
  template <class Pair>
  void restore(std::vector<Pair>& pairs) const {
    const auto comes_before = [this](const Pair& a, const Pair& b) {
      return turn_of(*a.soft, *a.object) < turn_of(*b.soft, *b.object);
    };
    if (!std::is_sorted(pairs.begin(), pairs.end(), comes_before)) {
      std::stable_sort(pairs.begin(), pairs.end(), comes_before);
    }
  }

 private:
  std::pair<int, int> turn_of(const btCollisionObject& a, const btCollisionObject& b) const;

  btOverlappingPairCache& pair_cache_;
  const btDispatcherInfo& info_;
};

}  // namespace softcd::bullet

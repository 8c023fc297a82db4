#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "native/pair_gate.hpp"

namespace softcd::bullet {

/// Returns the place of a pair in the order in which a single thread visits the pairs of the gate's world.
std::pair<int, int> turn_of(const btCollisionObject& a, const btCollisionObject& b, const PairGate& gate);

/// Sorts pairs into that order. Several threads visit them in another order in every run. Several pairs of the same two
/// objects (of a compound's children) keep their order: one thread found all of them. Throws nothing.
template <class Pair>
void restore_order(std::vector<Pair>& pairs, const PairGate& gate) {
  const auto comes_before = [&](const Pair& a, const Pair& b) {
    return turn_of(*a.soft, *a.object, gate) < turn_of(*b.soft, *b.object, gate);
  };
  if (std::is_sorted(pairs.begin(), pairs.end(), comes_before)) return;
  std::stable_sort(pairs.begin(), pairs.end(), comes_before);
}

}  // namespace softcd::bullet

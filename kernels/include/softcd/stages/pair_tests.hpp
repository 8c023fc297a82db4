#pragma once

#include <cstdint>

#include "softcd/core/count.hpp"
#include "softcd/grid/control_bits.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/stages/bounding_volumes.hpp"

namespace softcd {

/// Two triangles that may touch, lower index in the high half.
SOFTCD_HD constexpr std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) {
  return a < b ? (static_cast<std::uint64_t>(a) << 32) | b : (static_cast<std::uint64_t>(b) << 32) | a;
}

constexpr int kTimeSlabs = 8;

SOFTCD_HD inline Box box_at(const TriangleMotion& motion, float t) {
  Box box = box_of(lerp(motion.t0[0], motion.t1[0], t));
  for (int corner = 1; corner < 3; ++corner) box = merged(box, box_of(lerp(motion.t0[corner], motion.t1[corner], t)));
  return box;
}

/// Whether the triangles' boxes, `distance` apart at most, overlap within one of kTimeSlabs equal parts of the step.
SOFTCD_HD inline bool overlap_in_a_slab(const TriangleMotion& a, const TriangleMotion& b, float distance,
                                        float furthest) {
  const float reach = outward_up(distance + 8.0F * 1.1920929e-7F * furthest);
  Box box_a = box_at(a, 0.0F);
  Box box_b = box_at(b, 0.0F);
  for (int slab = 1; slab <= kTimeSlabs; ++slab) {
    const float t = static_cast<float>(slab) / kTimeSlabs;
    const Box next_a = box_at(a, t);
    const Box next_b = box_at(b, t);
    if (overlap(inflated(merged(box_a, next_a), reach), merged(box_b, next_b))) return true;
    box_a = next_a;
    box_b = next_b;
  }
  return false;
}

/// Two triangles that meet in a cell.
struct alignas(16) PairCandidate {
  Entry a, b;
};

/// What decides about a pair of triangles once it is known that they meet in a cell. Cheapest first.
struct PairTest {
  SceneView scene;
  const Kdop18* volumes;
  const TriangleShape* shapes;

  /// Whether some vertex or edge of one is owned that could touch the other.
  static SOFTCD_HD constexpr bool own_features(Entry a, Entry b) {
    return (owned_vertices(a) | owned_vertices(b)) != 0U || (owned_edges(a) != 0U && owned_edges(b) != 0U);
  }

  SOFTCD_HD bool may_touch(Entry a, Entry b) const {
    if (scene.body_count > 1 && !scene.bodies_may_touch(scene.triangle_body[a.root], scene.triangle_body[b.root])) {
      return false;
    }
    const Kdop18 volume_a = volumes[a.root];
    const Kdop18 volume_b = volumes[b.root];
    if (!overlap(volume_a, volume_b)) return false;
    if (!scene.continuous) return true;
    const TriangleMotion motion_a = load_triangle(scene, a.root);
    const TriangleMotion motion_b = load_triangle(scene, b.root);
    const float distance = outward_up(shapes[a.root].growth + shapes[b.root].growth);
    const float furthest = larger(furthest_coordinate(volume_a), furthest_coordinate(volume_b));
    if (apart_throughout(motion_a, motion_b, reach_of(distance, furthest))) return false;
    return !(is_fast(a) || is_fast(b)) || overlap_in_a_slab(motion_a, motion_b, distance, furthest);
  }
};

/// One test: sorted entry j against its k-th partner. `filter` decides by the entries alone and hands what is left, a
/// minority, to `test`, so that a backend may gather enough of it before it goes on.
template <class Control>
struct TestPair {
  using Candidate = PairCandidate;

  PairTest pair_test;
  const std::uint32_t* keys;
  const Entry* entries;
  const std::uint32_t* partner_begin;

  /// What all tests of one entry share.
  struct Item {
    Entry entry;
    const Entry* partners;
    std::uint32_t cell;
    std::uint32_t touchable_classes;  ///< bits of the body classes that the entry's body may touch
  };

  SOFTCD_HD Item load_item(std::uint32_t j) const {
    const Entry entry = entries[j];
    return {entry, entries + partner_begin[j], key_cell(keys[j]), pair_test.scene.class_may_touch[body_class(entry)]};
  }

  SOFTCD_HD bool filter(const Item& item, std::uint32_t k, PairCandidate& candidate) const {
    const Entry partner = item.partners[k];
    if (((item.touchable_classes >> body_class(partner)) & 1U) == 0U) return false;
    const Verdict verdict = Control::judge(item.cell, item.entry, partner);
    if (verdict == Verdict::skip || item.entry.root == partner.root) return false;
    if (!PairTest::own_features(item.entry, partner)) return false;
    candidate = {item.entry, partner};
    if (verdict == Verdict::execute_and_flag) candidate.a.bits |= kFlaggedPair;
    return true;
  }

  template <class Pairs, class Flagged>
  SOFTCD_HD void test(const PairCandidate& candidate, Pairs& pairs, Flagged& flagged) const {
    if (!pair_test.may_touch(candidate.a, candidate.b)) return;
    const std::uint64_t pair = pair_key(candidate.a.root, candidate.b.root);
    if ((candidate.a.bits & kFlaggedPair) == 0U) {
      pairs.push(pair);
    } else {
      flagged.push(pair);
    }
  }

 private:
  static constexpr std::uint32_t kFlaggedPair = 1U << 31;  ///< a spare bit of Entry
};

/// Triangle t against every triangle on the BIG list, each pair once.
struct TestAgainstBig {
  PairTest test;
  const std::uint32_t* bigs;
  Count big_count;

  template <class Pairs>
  SOFTCD_HD void operator()(std::uint32_t t, Pairs& pairs) const {
    if (is_empty(test.volumes[t])) return;
    const Entry a = entry_of(t);
    const bool is_big = (test.shapes[t].flags & kBigTriangle) != 0U;
    for (std::uint64_t i = 0; i < big_count.get(); ++i) {
      const std::uint32_t big = bigs[i];
      if (t == big || (is_big && t < big)) continue;
      const Entry b = entry_of(big);
      if (PairTest::own_features(a, b) && test.may_touch(a, b)) pairs.push(pair_key(t, big));
    }
  }

 private:
  SOFTCD_HD Entry entry_of(std::uint32_t t) const {
    return {t, entry_bits(0, test.scene.triangle_body[t], test.scene.ownership[t],
                          (test.shapes[t].flags & kFastTriangle) != 0U)};
  }
};

/// Keeps the first of each run of equal keys.
struct KeepFirst {
  const std::uint64_t* keys;

  template <class Pairs>
  SOFTCD_HD void operator()(std::uint32_t i, Pairs& pairs) const {
    if (i == 0 || keys[i - 1] != keys[i]) pairs.push(keys[i]);
  }
};

}  // namespace softcd

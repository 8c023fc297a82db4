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

SOFTCD_HD inline Kdop18 kdop_of(const Vec3f (&corners)[3]) {
  Kdop18 volume = empty_kdop();
  for (const Vec3f& corner : corners) extend(volume, corner);
  return volume;
}

SOFTCD_HD inline Box box_at(const TriangleMotion& motion, float t) {
  Box box = box_of(lerp(motion.t0[0], motion.t1[0], t));
  for (int corner = 1; corner < 3; ++corner) box = merged(box, box_of(lerp(motion.t0[corner], motion.t1[corner], t)));
  return box;
}

/// Whether the triangles' boxes, `gap` apart at most, overlap within one of kTimeSlabs equal parts of the step.
SOFTCD_HD inline bool overlap_in_a_slab(const TriangleMotion& a, const TriangleMotion& b, float gap) {
  float furthest = 0.0F;
  for (int corner = 0; corner < 3; ++corner) {
    furthest = larger(furthest, larger(max_norm(a.t0[corner]), max_norm(a.t1[corner])));
    furthest = larger(furthest, larger(max_norm(b.t0[corner]), max_norm(b.t1[corner])));
  }
  const float reach = outward_up(gap + 8.0F * 1.1920929e-7F * furthest);
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
    if (a.root == b.root || !own_features(a, b)) return false;
    if (!overlap(volumes[a.root], volumes[b.root])) return false;
    if (!scene.bodies_may_touch(scene.triangle_body[a.root], scene.triangle_body[b.root])) return false;
    if (!scene.continuous) return true;
    const TriangleMotion motion_a = load_triangle(scene, a.root);
    const TriangleMotion motion_b = load_triangle(scene, b.root);
    const float gap = outward_up(shapes[a.root].growth + shapes[b.root].growth);
    if (apart_throughout(kdop_of(motion_a.t0), kdop_of(motion_a.t1), kdop_of(motion_b.t0), kdop_of(motion_b.t1), gap))
      return false;
    return !(is_fast(a) || is_fast(b)) || overlap_in_a_slab(motion_a, motion_b, gap);
  }
};

/// One test: sorted entry j against its k-th partner.
template <class Control>
struct TestPair {
  PairTest test;
  const std::uint32_t* keys;
  const Entry* entries;
  const std::uint32_t* partner_begin;

  template <class Pairs, class Flagged>
  SOFTCD_HD void operator()(std::uint32_t j, std::uint32_t k, Pairs& pairs, Flagged& flagged) const {
    const Entry a = entries[j];
    const Entry b = entries[partner_begin[j] + k];
    const Verdict verdict = Control::judge(key_cell(keys[j]), a, b);
    if (verdict == Verdict::skip || !test.may_touch(a, b)) return;
    if (verdict == Verdict::execute) {
      pairs.push(pair_key(a.root, b.root));
    } else {
      flagged.push(pair_key(a.root, b.root));
    }
  }
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
      if (is_big && t <= big) continue;
      if (test.may_touch(a, entry_of(big))) pairs.push(pair_key(t, big));
    }
  }

 private:
  SOFTCD_HD Entry entry_of(std::uint32_t t) const {
    return {t, entry_bits(0, test.scene.ownership[t], (test.shapes[t].flags & kFastTriangle) != 0U)};
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

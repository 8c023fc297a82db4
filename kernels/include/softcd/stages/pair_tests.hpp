#pragma once

#include <cstdint>

#include "softcd/core/count.hpp"
#include "softcd/grid/control_bits.hpp"
#include "softcd/math/box.hpp"
#include "softcd/math/end_volumes.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/cell_ranges.hpp"
#include "softcd/stages/shared_vertex_test.hpp"
#include "softcd/stages/slab_reach.hpp"

namespace softcd {

/// Returns the key of two triangles or patches, the lower index in the high half.
SOFTCD_HD constexpr std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) {
  return a < b ? (static_cast<std::uint64_t>(a) << 32) | b : (static_cast<std::uint64_t>(b) << 32) | a;
}

/// Appends a pair of triangles to `pairs`, and a pair with a patch to `patch_pairs`. A patch is the higher of the two.
template <class Pairs, class PatchPairs>
SOFTCD_HD void push_pair(const SceneView& scene, std::uint64_t pair, Pairs& pairs, PatchPairs& patch_pairs) {
  if (scene.is_patch(static_cast<std::uint32_t>(pair))) {
    patch_pairs.push(pair);
  } else {
    pairs.push(pair);
  }
}

constexpr int kTimeSlabs = 8;

/// Whether one moves further relative to the other than the two are wide. Then time slabs may separate them where no
/// axis does.
SOFTCD_HD inline bool move_past(const EndVolumes& a, const EndVolumes& b) {
  float motion = 0.0F;
  float width = 0.0F;
  for (int axis = 0; axis < 3; ++axis) {
    const EndVolumes::Axis on_a = a.axes[axis];
    const EndVolumes::Axis on_b = b.axes[axis];
    const float motion_a = (on_a.t1_lo + on_a.t1_hi) - (on_a.t0_lo + on_a.t0_hi);
    const float motion_b = (on_b.t1_lo + on_b.t1_hi) - (on_b.t0_lo + on_b.t0_hi);
    motion = larger(motion, 0.5F * magnitude(motion_a - motion_b));
    width = larger(width, (on_a.t1_hi - on_a.t1_lo) + (on_b.t1_hi - on_b.t1_lo));
  }
  return motion > width;
}

SOFTCD_HD inline Box box_at(const TriangleMotion& motion, float t) {
  Box box = box_of(lerp(motion.t0[0], motion.t1[0], t));
  for (int corner = 1; corner < 3; ++corner) box = merged(box, box_of(lerp(motion.t0[corner], motion.t1[corner], t)));
  return box;
}

/// Whether the triangles' boxes, `distance` apart at most, overlap within one of kTimeSlabs equal parts of the step.
SOFTCD_HD inline bool overlap_in_a_slab(const TriangleMotion& a, const TriangleMotion& b, float distance,
                                        float furthest) {
  const float growth = outward_up(distance + kCoordinateError * furthest);
  Box box_a = box_at(a, 0.0F);
  Box box_b = box_at(b, 0.0F);
  for (int slab = 1; slab <= kTimeSlabs; ++slab) {
    const float t = static_cast<float>(slab) / kTimeSlabs;
    const Box next_a = box_at(a, t);
    const Box next_b = box_at(b, t);
    if (overlap(inflated(merged(box_a, next_a), growth), merged(box_b, next_b))) return true;
    box_a = next_a;
    box_b = next_b;
  }
  return false;
}

/// Two triangles or patches that meet in a cell.
struct alignas(16) PairCandidate {
  Entry a, b;
};

/// Decides about a pair of triangles or patches that meet in a cell. The cheapest tests come first. With a patch it
/// decides whether some of the patch's triangles may be such a pair.
template <bool kSwept>
struct PairTest {
  SceneView scene;
  const Kdop18* volumes;
  const EndVolumes* end_volumes;  ///< null unless swept
  const TriangleShape* shapes;
  /// Null unless pairs that certainly_beyond_slabs() are left out.
  const SlabReach* slabs = nullptr;

  /// Whether one owns a vertex or an edge that could touch the other.
  static SOFTCD_HD constexpr bool own_features(Entry a, Entry b) {
    const bool any_vertex = (owned_vertices(a) | owned_vertices(b)) != 0U;
    const bool edges_of_a = owned_edges(a) != 0U;
    const bool edges_of_b = owned_edges(b) != 0U;
    return any_vertex | (edges_of_a & edges_of_b);
  }

  /// Whether bodies of the two entries' classes may touch.
  SOFTCD_HD bool classes_may_touch(std::uint32_t touchable_by_a, Entry b) const {
    return ((touchable_by_a >> body_class(b)) & 1U) != 0U;
  }
  /// Returns the entry of a triangle or a patch outside of any cell.
  SOFTCD_HD Entry entry_of(std::uint32_t element) const {
    return {element, entry_bits(0, scene.element_body(element), wanted_features(shapes[element].flags))};
  }
  SOFTCD_HD std::uint32_t touchable_classes(Entry a) const { return scene.class_may_touch[body_class(a)]; }

  /// Whether the bodies of two entries may touch if their classes may.
  SOFTCD_HD bool bodies_may_touch(Entry a, Entry b) const {
    return scene.body_count <= kBodyClasses ||
           scene.bodies_may_touch(scene.element_body(a.root), scene.element_body(b.root));
  }

  /// Whether two entries may touch if their classes may: not if they are neighbours whose features are listed.
  SOFTCD_HD bool may_touch(Entry a, Entry b) const {
    if (!bodies_may_touch(a, b)) return false;
    if ((unsigned{scene.is_patch(a.root)} | unsigned{scene.is_patch(b.root)}) != 0U)
      return volumes_meet(a.root, b.root);
    if (scene.self_collision && share_vertex(scene.triangles[a.root], scene.triangles[b.root])) {
      return neighbours_may_touch(a.root, b.root);
    }
    return may_meet(a.root, b.root);
  }

  /// Decides the same for triangles of bodies that may touch, which share no vertex.
  SOFTCD_HD bool may_meet(std::uint32_t a, std::uint32_t b) const {
    return volumes_meet(a, b) && meet_within_volumes(a, b);
  }

  /// Decides the same for such triangles that meet by volumes_meet().
  SOFTCD_HD bool meet_within_volumes(std::uint32_t a, std::uint32_t b) const {
    if constexpr (kSwept) return !move_past(end_volumes[a], end_volumes[b]) || meet_in_a_slab(a, b);
    return slabs == nullptr || !are_beyond_slabs(a, b);
  }

  /// Decides the same for triangles that meet by volumes_meet(), of bodies that may touch.
  SOFTCD_HD bool meeting_triangles_may_touch(std::uint32_t a, std::uint32_t b) const {
    if (scene.self_collision && share_vertex(scene.triangles[a], scene.triangles[b])) return neighbours_may_touch(a, b);
    return meet_within_volumes(a, b);
  }

  /// Whether triangles of which one moves past the other meet in a time slab.
  SOFTCD_HD_SELDOM bool meet_in_a_slab(std::uint32_t a, std::uint32_t b) const {
    const float distance = outward_up(shapes[a].growth + shapes[b].growth);
    const float furthest = larger(furthest_coordinate(volumes[a]), furthest_coordinate(volumes[b]));
    return overlap_in_a_slab(load_triangle(scene, a), load_triangle(scene, b), distance, furthest);
  }

 private:
  SOFTCD_HD bool volumes_meet(std::uint32_t a, std::uint32_t b) const {
    if constexpr (kSwept) {
      return !certainly_apart_throughout(end_volumes[a], end_volumes[b]);
    } else {
      return overlap(volumes[a], volumes[b]);
    }
  }

  SOFTCD_HD bool are_beyond_slabs(std::uint32_t a, std::uint32_t b) const {
    const float growth = outward_down(shapes[a].growth + shapes[b].growth);
    return certainly_beyond_slabs(volumes[a], volumes[b], growth, slabs[a], slabs[b]);
  }

  SOFTCD_HD bool neighbours_may_touch(std::uint32_t a, std::uint32_t b) const {
    const SceneBody& body = scene.bodies[scene.triangle_body[a]];
    if (body.lists_neighbours) return false;
    float distance = scene.contact_distance(outward_up(body.margin + body.margin));
    if (body.is_rounded) distance = outward_up(distance + outward_up(shapes[a].rounding + shapes[b].rounding));
    return SharedVertexTest<kSwept>{scene}.may_touch(scene.triangles[a], scene.triangles[b], distance);
  }
};

/// One test: sorted entry j against its k-th partner. `filter` decides by the entries alone. It passes a minority to
/// `test`, so that a backend may gather enough of it before it goes on.
template <class Control, bool kSwept>
struct TestPair {
  using Candidate = PairCandidate;

  PairTest<kSwept> pair_test;
  const std::uint32_t* keys;
  const BoxedEntry* entries;
  const std::uint32_t* partner_begin;

  /// Properties that all tests of one entry share.
  struct Item {
    BoxedEntry boxed;
    const BoxedEntry* partners;
    std::uint32_t cell;
    std::uint32_t touchable_classes;  ///< bits of the body classes that the entry's body may touch
  };

  SOFTCD_HD Item load_item(std::uint32_t j) const {
    const BoxedEntry boxed = entries[j];
    return {boxed, entries + partner_begin[j], key_cell(keys[j]), pair_test.touchable_classes(boxed.entry())};
  }

  SOFTCD_HD bool filter(const Item& item, std::uint32_t k, PairCandidate& candidate) const {
    const BoxedEntry boxed_partner = item.partners[k];  // by value: the device reads it in 16-byte pieces
    const Entry entry = item.boxed.entry();
    const Entry partner = boxed_partner.entry();
    const bool boxes_meet = !boxes_certainly_apart<kSwept>(item.boxed, boxed_partner);
    const Verdict verdict = Control::judge(item.cell, entry, partner);
    candidate = {entry, partner};
    candidate.a.bits |= verdict == Verdict::execute_and_flag ? kFlaggedPair : 0U;
    const bool may_touch = pair_test.classes_may_touch(item.touchable_classes, partner);
    const bool own_features = pair_test.own_features(entry, partner);
    return boxes_meet & (verdict != Verdict::skip) & (entry.root != partner.root) & may_touch & own_features;
  }

  template <class Pairs, class PatchPairs, class Flagged>
  SOFTCD_HD void test(const PairCandidate& candidate, Pairs& pairs, PatchPairs& patch_pairs, Flagged& flagged) const {
    if (!pair_test.may_touch(candidate.a, candidate.b)) return;
    const std::uint64_t pair = pair_key(candidate.a.root, candidate.b.root);
    if ((candidate.a.bits & kFlaggedPair) == 0U) {
      push_pair(pair_test.scene, pair, pairs, patch_pairs);
    } else {
      flagged.push(pair);
    }
  }

 private:
  static constexpr std::uint32_t kFlaggedPair = 1U << 31;  ///< a spare bit of Entry
};

/// Tests a rank's triangle, or its patch if there are patches, with index first + i against every triangle on the BIG
/// list, each pair once.
template <bool kSwept>
struct TestAgainstBig {
  PairTest<kSwept> test;
  const std::uint32_t* bigs;
  Count big_count;
  std::uint32_t first = 0;

  template <class Pairs, class PatchPairs>
  SOFTCD_HD void operator()(std::uint32_t i, Pairs& pairs, PatchPairs& patch_pairs) const {
    if (test.scene.patch_count == 0) return against_all(first + i, pairs, patch_pairs);
    const std::uint32_t patch = test.scene.patch_element(first + i);
    if ((test.shapes[patch].flags & kLoosePatch) == 0U) return against_all(patch, pairs, patch_pairs);
    for (std::uint32_t k = 0; k < kPatchSize; ++k) {
      const std::uint32_t t = test.scene.element_triangle(patch, k);
      if (t != kNoIndex) against_all(t, pairs, patch_pairs);
    }
  }

 private:
  template <class Pairs, class PatchPairs>
  SOFTCD_HD void against_all(std::uint32_t t, Pairs& pairs, PatchPairs& patch_pairs) const {
    if (is_empty(test.volumes[t])) return;
    const Entry a = test.entry_of(t);
    const std::uint32_t touchable = test.touchable_classes(a);
    const bool is_big = (test.shapes[t].flags & kBigTriangle) != 0U;
    for (std::uint64_t k = 0; k < big_count.get(); ++k) {
      const std::uint32_t big = bigs[k];
      if (t == big || (is_big && t < big)) continue;
      const Entry b = test.entry_of(big);
      if (!test.classes_may_touch(touchable, b) || !test.own_features(a, b)) continue;
      if (test.may_touch(a, b)) push_pair(test.scene, pair_key(t, big), pairs, patch_pairs);
    }
  }
};

/// Keeps the first of each run of equal keys.
struct KeepFirst {
  const std::uint64_t* keys;
  SceneView scene;

  template <class Pairs, class PatchPairs>
  SOFTCD_HD void operator()(std::uint32_t i, Pairs& pairs, PatchPairs& patch_pairs) const {
    if (i == 0 || keys[i - 1] != keys[i]) push_pair(scene, keys[i], pairs, patch_pairs);
  }
};

}  // namespace softcd

#pragma once

#include <cstdint>

#include "softcd/math/impact/impact.hpp"
#include "softcd/math/separation.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/mesh/topology.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/contact_tests.hpp"
#include "softcd/stages/vertex_stars.hpp"

namespace softcd {

/// Number of bits set among the lowest three. A table of the eight cases.
SOFTCD_HD constexpr std::uint32_t count_bits3(std::uint32_t bits) {
  return (0xE994U >> (2U * (bits & 7U))) & 3U;
}

/// Index of the n-th set bit (n from 0) among the lowest three, of which more than n are set. A table of the eight
/// cases, with three indices each.
SOFTCD_HD constexpr int nth_bit3(std::uint32_t bits, std::uint32_t n) {
  return static_cast<int>((0x909202101000ULL >> (6U * (bits & 7U) + 2U * n)) & 3U);
}

/// How near features have to be for a contact. Upper bounds: the narrow phase computes the margin itself.
struct FeatureReach {
  float margin;    ///< no less than contact_margin
  float distance;  ///< within which they can be in contact
};

/// Two triangles that may touch, and which corners (vertex-triangle) or sides (edge-edge) of each the pair has to test.
template <ContactKind kKind>
struct FeatureWork {
  std::uint32_t a, b;
  Triangle corners_a, corners_b;
  std::uint32_t owned_a, owned_b;  ///< three bits each
  FeatureReach reach_a, reach_b;   ///< of the corners of each, of sides both the same

  SOFTCD_HD std::uint32_t part_count() const {
    const std::uint32_t count_a = count_bits3(owned_a);
    const std::uint32_t count_b = count_bits3(owned_b);
    return kKind == ContactKind::vertex_triangle ? count_a + count_b : count_a * count_b;
  }
};

/// A vertex and a triangle, or two edges: their vertices in the order of contact_margin, and their indices.
struct FeatureCandidate {
  FeatureVertices vertices;
  std::uint32_t first, second;
  FeatureReach reach;
};

/// Rejects features that are certain to stay apart:
/// - along x, y or z at both ends of the step,
/// - out of each other's plane,
/// - by the signs of the coplanarity cubic,
/// - or along some direction at both ends of the step.
/// The order follows from what each test rejects for its cost. Tests are in float, whatever the narrow phase computes
/// in: all rejected features are apart in exact arithmetic. A candidate's distance covers the rounding of positions:
/// features further apart than that as floats are further apart than their margins as given.
template <ContactKind kKind, bool kSwept>
struct FeatureTest {
  SceneView scene;

  /// Returns false if the features are apart along x, y or z: most are.
  SOFTCD_HD bool filter(const FeatureCandidate& candidate) const {
    return !certainly_apart_on_straight_axes<kSwept, kCountA>(load(candidate.vertices),
                                                              straight_distance(candidate.reach.distance));
  }

  /// Returns the reach for a sum of margins, and a sum of corners' roundings.
  SOFTCD_HD FeatureReach reach_of(float margin, float rounding) const {
    FeatureReach reach{};
    reach.margin = outward_up(margin);
    reach.distance = kKind == ContactKind::vertex_triangle ? scene.contact_distance(reach.margin) : reach.margin;
    if (rounding > 0.0F) reach.distance = outward_up(reach.distance + outward_up(rounding));
    return reach;
  }

  /// Returns false if the features, which pass the filter, are certain to stay apart.
  SOFTCD_HD bool keeps(const FeatureCandidate& candidate) const {
    const PointMotion<4> points = load(candidate.vertices);
    const float margin = candidate.reach.distance;
    float height = margin;
    if constexpr (!kSwept && kKind == ContactKind::vertex_triangle) {
      if (scene.has_certain_slabs()) {
        if (certainly_beside_slab(candidate)) return false;
        height = candidate.reach.margin;
      }
    }
    if constexpr (kSwept) {
      const bool is_out = scene.is_conservative ? certainly_apart_throughout<kKind>(points.t0, points.t1, margin)
                                                : certainly_apart_when_coplanar<kKind>(points.t0, points.t1, margin);
      if (is_out) return false;
    } else {
      if (certainly_apart<kKind>(points.t1, height)) return false;
    }
    return !certainly_apart_in_a_direction<kKind, kSwept>(points, margin);
  }

  template <class Candidates>
  SOFTCD_HD void append(const FeatureCandidate& candidate, Candidates& candidates) const {
    const bool in_order = kKind == ContactKind::vertex_triangle || candidate.first < candidate.second;
    const std::uint64_t high = in_order ? candidate.first : candidate.second;
    candidates.push((high << 32) | (in_order ? candidate.second : candidate.first));
  }

  template <class Candidates>
  SOFTCD_HD void test(const FeatureCandidate& candidate, Candidates& candidates) const {
    if (keeps(candidate)) append(candidate, candidates);
  }

 private:
  static constexpr int kCountA = kKind == ContactKind::vertex_triangle ? 1 : 2;

  SOFTCD_HD PointMotion<4> load(const FeatureVertices& vertices) const {
    PointMotion<4> motion{};
    for (int i = 0; i < 4; ++i) {
      motion.t1[i] = scene.x_t1[vertices.v[i]];
      motion.t0[i] = kSwept ? scene.x_t0[vertices.v[i]] : motion.t1[i];
    }
    return motion;
  }

  SOFTCD_HD_SELDOM bool certainly_beside_slab(FeatureCandidate candidate) const {
    const PointMotion<4> points = load(candidate.vertices);
    return certainly_outside_slab(detail::relative_pair<kKind>(points.t1), candidate.reach.margin);
  }
};

/// Expands a pair of triangles into the candidates of one kind that the two own (R-triangles), if both bodies want that
/// kind. A part is one such candidate; it is kept unless the features share a vertex (they are always in contact), or
/// FeatureTest rejects them.
template <ContactKind kKind, bool kSwept>
struct ExpandPair {
  using Item = FeatureWork<kKind>;
  using Candidate = FeatureCandidate;

  FeatureTest<kKind, kSwept> feature_test;
  const TriangleShape* shapes;
  const Kdop18* volumes;
  const std::uint64_t* pairs;

  SOFTCD_HD Item load_item(std::uint32_t i) const {
    const auto a = static_cast<std::uint32_t>(pairs[i] >> 32);
    const auto b = static_cast<std::uint32_t>(pairs[i]);
    const SceneView& scene = feature_test.scene;
    const TriangleShape shape_a = shapes[a];
    const TriangleShape shape_b = shapes[b];
    constexpr std::uint32_t kWanted = kKind == ContactKind::vertex_triangle ? kWantsVertexTriangle : kWantsEdgeEdge;
    constexpr std::uint32_t kShift = kKind == ContactKind::vertex_triangle ? 0 : 3;
    const std::uint32_t bits = (shape_a.flags & shape_b.flags & kWanted) != 0U ? 7U : 0U;
    Item work{};
    work.owned_a = (shape_a.flags >> kShift) & bits_against(shape_b, bits);
    work.owned_b = (shape_b.flags >> kShift) & bits_against(shape_a, bits);
    if (work.part_count() == 0) return work;
    const std::uint32_t body_a = scene.triangle_body[a];
    const std::uint32_t body_b = scene.triangle_body[b];
    const float margin_a = scene.bodies[body_a].margin;
    const float margin_b = scene.bodies[body_b].margin;
    const float rounding = shape_a.rounding + shape_b.rounding;
    work.reach_a = work.reach_b = feature_test.reach_of(margin_a + margin_b, rounding);
    if (kKind == ContactKind::vertex_triangle && body_a != body_b && scene.motion_margin > 0.0F) {
      // A vertex's margin grows with its motion, and no triangle around it has grown by less.
      work.reach_a = feature_test.reach_of(shape_a.growth + margin_b, rounding);
      work.reach_b = feature_test.reach_of(margin_a + shape_b.growth, rounding);
    }
    if constexpr (kKind == ContactKind::edge_edge && !kSwept) {
      // Triangles may have been grown for their vertices' contacts, which reach farther than those of edges.
      const float growth = outward_down(shape_a.growth + shape_b.growth);
      if (certainly_apart_before_growth(volumes[a], volumes[b], growth, work.reach_a.distance)) {
        work.owned_a = 0;
        return work;
      }
    }
    work.a = a;
    work.b = b;
    work.corners_a = scene.triangles[a];
    work.corners_b = scene.triangles[b];
    return work;
  }

  /// Returns false if the features share a vertex or are apart along x, y or z: most are.
  SOFTCD_HD bool filter(const Item& work, std::uint32_t part, Candidate& candidate) const {
    if (!pick(work, part, candidate) || !feature_test.filter(candidate)) return false;
    name(work, part, candidate);
    return true;
  }

  /// Does the same without the test: returns false if the features share a vertex.
  SOFTCD_HD bool list(const Item& work, std::uint32_t part, Candidate& candidate) const {
    if (!pick(work, part, candidate)) return false;
    name(work, part, candidate);
    return true;
  }

  template <class Candidates>
  SOFTCD_HD void test(const FeatureCandidate& candidate, Candidates& candidates) const {
    feature_test.test(candidate, candidates);
  }
  template <class Candidates>
  SOFTCD_HD void append(const FeatureCandidate& candidate, Candidates& candidates) const {
    feature_test.append(candidate, candidates);
  }

 private:
  /// Vertices are not tested against segments: if the two touch, edges touch at an end.
  static SOFTCD_HD std::uint32_t bits_against(const TriangleShape& other, std::uint32_t bits) {
    return kKind == ContactKind::vertex_triangle && (other.flags & kSegment) != 0U ? 0U : bits;
  }

  /// Finds the vertices of a part and their reach. Returns false if two are the same.
  SOFTCD_HD bool pick(const Item& work, std::uint32_t part, Candidate& candidate) const {
    if constexpr (kKind == ContactKind::vertex_triangle) {
      const std::uint32_t count_a = count_bits3(work.owned_a);
      const bool is_of_a = part < count_a;
      const int corner = is_of_a ? nth_bit3(work.owned_a, part) : nth_bit3(work.owned_b, part - count_a);
      const std::uint32_t v = (is_of_a ? work.corners_a : work.corners_b).v[corner];
      const Triangle& t = is_of_a ? work.corners_b : work.corners_a;
      if (v == t.v[0] || v == t.v[1] || v == t.v[2]) return false;
      candidate.vertices = {{v, t.v[0], t.v[1], t.v[2]}};
      candidate.reach = is_of_a ? work.reach_a : work.reach_b;
    } else {
      const std::uint32_t count_b = count_bits3(work.owned_b);
      const int side_a = nth_bit3(work.owned_a, part / count_b);
      const int side_b = nth_bit3(work.owned_b, part % count_b);
      const Triangle& t = work.corners_a;
      const Triangle& u = work.corners_b;
      const std::uint32_t p = t.v[side_a];
      const std::uint32_t q = t.v[side_a == 2 ? 0 : side_a + 1];
      const std::uint32_t r = u.v[side_b];
      const std::uint32_t s = u.v[side_b == 2 ? 0 : side_b + 1];
      if (p == r || p == s || q == r || q == s) return false;
      candidate.vertices = {{p, q, r, s}};
      candidate.reach = work.reach_a;
    }
    return true;
  }

  /// Finds the features' indices.
  SOFTCD_HD void name(const Item& work, std::uint32_t part, Candidate& candidate) const {
    if constexpr (kKind == ContactKind::vertex_triangle) {
      candidate.first = candidate.vertices.v[0];
      candidate.second = part < count_bits3(work.owned_a) ? work.b : work.a;
    } else {
      const std::uint32_t count_b = count_bits3(work.owned_b);
      const TriangleEdges* edges = feature_test.scene.triangle_edges;
      candidate.first = edges[work.a].e[nth_bit3(work.owned_a, part / count_b)];
      candidate.second = edges[work.b].e[nth_bit3(work.owned_b, part % count_b)];
    }
  }
};

/// Tests the listed features of triangles that share a vertex (NeighbourFeatures), one per item.
template <ContactKind kKind, bool kSwept>
struct TestNeighbours {
  struct Item {
    std::uint64_t features;

    SOFTCD_HD std::uint32_t part_count() const { return 1; }
  };
  using Candidate = FeatureCandidate;

  FeatureTest<kKind, kSwept> feature_test;
  const std::uint64_t* neighbours;
  SpreadParts spread;  ///< filled

  SOFTCD_HD Item load_item(std::uint32_t i) const { return {neighbours[i]}; }

  SOFTCD_HD bool filter(const Item& item, std::uint32_t part, FeatureCandidate& candidate) const {
    return list(item, part, candidate) && feature_test.filter(candidate);
  }

  /// Returns false if the item has none, they lie in a star that is spread out, or the body wants no such contacts.
  SOFTCD_HD bool list(const Item& item, std::uint32_t /*part*/, FeatureCandidate& candidate) const {
    if (item.features == kNoFeatures || are_spread<kKind>(spread, item.features)) return false;
    const SceneView& scene = feature_test.scene;
    candidate.vertices = feature_vertices<kKind>(scene, item.features);
    candidate.first = first_feature(item.features);
    candidate.second = second_feature(item.features);
    const SceneBody& body = scene.bodies[scene.vertex_body[candidate.vertices.v[0]]];
    candidate.reach = feature_test.reach_of(body.margin + body.margin, rounding_of(body, candidate.vertices));
    const bool is_wanted = kKind == ContactKind::vertex_triangle ? body.vertex_triangle : body.edge_edge;
    return body.lists_neighbours && is_wanted;
  }

  template <class Candidates>
  SOFTCD_HD void test(const FeatureCandidate& candidate, Candidates& candidates) const {
    feature_test.test(candidate, candidates);
  }
  template <class Candidates>
  SOFTCD_HD void append(const FeatureCandidate& candidate, Candidates& candidates) const {
    feature_test.append(candidate, candidates);
  }

 private:
  /// Returns the rounding of two features' corners together.
  SOFTCD_HD float rounding_of(const SceneBody& body, const FeatureVertices& vertices) const {
    if (!body.is_rounded) return 0.0F;
    float rounding = 0.0F;
    for (const std::uint32_t v : vertices.v) rounding = larger(rounding, feature_test.scene.vertex_rounding(body, v));
    return 2.0F * rounding;
  }
};

}  // namespace softcd

#pragma once

#include <cstdint>

#include "softcd/math/closest_point.hpp"
#include "softcd/stages/boxes_ahead.hpp"
#include "softcd/stages/feature_pairs.hpp"

/// Excludes candidates by their vertices' groups and masks, because they are near on their mesh or at rest, or because
/// they do not lie ahead (ContactRule::ahead).
namespace softcd {

/// Whether the filters allow two features to touch.
template <ContactKind kKind>
struct FilterTest {
  SceneView scene;

  SOFTCD_HD bool may_touch(const FeatureVertices& vertices) const {
    if (scene.filters.vertices != nullptr && !any_pair(vertices, GroupsAllow{scene.filters.vertices})) return false;
    const std::uint32_t body_a = scene.vertex_body[vertices.v[0]];
    if (body_a != scene.vertex_body[vertices.v[kCountA]]) return true;
    const SceneBody& body = scene.bodies[body_a];
    if (body.excludes_rings && any_pair(vertices, AreNearOnMesh{scene.filters})) return false;
    return !(body.rest_distance > 0.0F) || !are_near_at_rest(vertices, body.rest_distance);
  }

 private:
  /// Vertices of the first feature; the others are the second's.
  static constexpr int kCountA = kKind == ContactKind::vertex_triangle ? 1 : 2;

  struct GroupsAllow {
    const VertexFilter* filters;

    SOFTCD_HD bool operator()(std::uint32_t v, std::uint32_t w) const {
      const VertexFilter a = filters[v];
      const VertexFilter b = filters[w];
      return (a.group & b.mask) != 0U && (b.group & a.mask) != 0U;
    }
  };

  struct AreNearOnMesh {
    FeatureFilters filters;

    SOFTCD_HD bool operator()(std::uint32_t v, std::uint32_t w) const {
      std::uint64_t first = filters.ring_begin[v];
      std::uint64_t last = filters.ring_begin[v + 1];
      while (first < last) {
        const std::uint64_t middle = first + (last - first) / 2;
        if (filters.ring_vertices[middle] == w) return true;
        if (filters.ring_vertices[middle] < w) {
          first = middle + 1;
        } else {
          last = middle;
        }
      }
      return false;
    }
  };

  /// Whether `relation` holds for some vertex of one feature and some of the other.
  template <class Relation>
  static SOFTCD_HD bool any_pair(const FeatureVertices& vertices, const Relation& relation) {
    for (int a = 0; a < kCountA; ++a) {
      for (int b = kCountA; b < 4; ++b) {
        if (relation(vertices.v[a], vertices.v[b])) return true;
      }
    }
    return false;
  }

  SOFTCD_HD bool are_near_at_rest(const FeatureVertices& vertices, float distance) const {
    Vec3d x[4];
    for (int corner = 0; corner < 4; ++corner) x[corner] = vec3_cast<double>(scene.filters.x_rest[vertices.v[corner]]);
    if constexpr (kKind == ContactKind::vertex_triangle) {
      return closest_points_vertex_triangle(x[0], x[1], x[2], x[3]).are_within(static_cast<double>(distance));
    } else {
      return closest_points_edge_edge(x[0], x[1], x[2], x[3]).are_within(static_cast<double>(distance));
    }
  }
};

/// Returns whether ContactRule::ahead may exclude contacts within this reach. What is within twice the sum of both
/// bodies' margins always lies ahead.
SOFTCD_HD inline bool reaches_behind(const FeatureReach& reach, float margins) {
  return !(reach.margin <= kAheadMargins * margins);
}

/// Clears the corners of two triangles that need no test, because none lies ahead.
SOFTCD_HD inline void leave_out_behind(const SceneView& scene, FeatureWork<ContactKind::vertex_triangle>& work) {
  if (!scene.looks_ahead() || work.part_count() == 0) return;
  const float margins =
      scene.bodies[scene.triangle_body[work.a]].margin + scene.bodies[scene.triangle_body[work.b]].margin;
  if (work.owned_a != 0U && reaches_behind(work.reach_a, margins) &&
      !may_meet(vertices_ahead(scene, work.corners_a.v), triangle_ahead(scene, work.corners_b), margins)) {
    work.owned_a = 0;
  }
  if (work.owned_b != 0U && reaches_behind(work.reach_b, margins) &&
      !may_meet(vertices_ahead(scene, work.corners_b.v), triangle_ahead(scene, work.corners_a), margins)) {
    work.owned_b = 0;
  }
}
template <class Item>
SOFTCD_HD void leave_out_behind(const SceneView& /*scene*/, Item& /*item*/) {}

template <ContactKind kKind, bool kSwept>
SOFTCD_HD bool filters_allow(const FeatureTest<kKind, kSwept>& test, const FeatureCandidate& candidate) {
  if constexpr (kKind == ContactKind::vertex_triangle) {
    const SceneView& scene = test.scene;
    const std::uint32_t(&v)[4] = candidate.vertices.v;
    if (scene.looks_ahead()) {
      const float margins = scene.bodies[scene.vertex_body[v[0]]].margin + scene.bodies[scene.vertex_body[v[1]]].margin;
      if (reaches_behind(candidate.reach, margins) &&
          !may_meet(vertices_ahead(scene, {v[0]}), triangle_ahead(scene, Triangle{{v[1], v[2], v[3]}}), margins)) {
        return false;
      }
    }
  }
  return FilterTest<kKind>{test.scene}.may_touch(candidate.vertices);
}

/// Finds what `Find` finds, ExpandPair or TestNeighbours, without what the filters exclude. It is a functor of its own,
/// so that detections without filters do not pay for its registers.
template <class Find>
struct WithFilters : Find {
  SOFTCD_HD typename Find::Item load_item(std::uint32_t i) const {
    typename Find::Item item = Find::load_item(i);
    leave_out_behind(this->feature_test.scene, item);
    return item;
  }
  template <class Candidates>
  SOFTCD_HD void test(const FeatureCandidate& candidate, Candidates& candidates) const {
    if (this->feature_test.keeps(candidate)) append(candidate, candidates);
  }
  template <class Candidates>
  SOFTCD_HD void append(const FeatureCandidate& candidate, Candidates& candidates) const {
    if (filters_allow(this->feature_test, candidate)) Find::append(candidate, candidates);
  }
};

}  // namespace softcd

#pragma once

#include <cstdint>

#include "softcd/math/star.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/mesh/vertex_stars.hpp"
#include "softcd/stages/contact_tests.hpp"

/// Neighbours' features that need no test: those in a star that is spread out. Most stars of a surface are.
namespace softcd {

/// Stars that are spread out, and what lies in such stars only; one byte each, 0 or 1.
struct SpreadParts {
  std::uint8_t* vertices;   ///< the stars' centres
  std::uint8_t* triangles;  ///< all three corners are
  std::uint8_t* edges;      ///< the triangle that owns the edge is
};

/// Finds out whether a star is spread out.
struct TestStar {
  SceneView scene;
  const VertexStar* stars;
  SpreadParts spread;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const VertexStar& star = stars[i];
    if (!scene.bodies[scene.vertex_body[star.centre]].has_stars) return;
    const bool is_spread = scene.is_swept ? is_certainly_spread<true>(star) : is_certainly_spread<false>(star);
    spread.vertices[star.centre] = is_spread ? 1 : 0;
  }

  /// Returns a distance within which features of the star can be in contact.
  SOFTCD_HD float distance_of(const VertexStar& star) const {
    const SceneBody& body = scene.bodies[scene.vertex_body[star.centre]];
    const float distance = scene.contact_distance(outward_up(body.margin + body.margin));
    return body.is_rounded ? outward_up(distance + 2.0F * rounding_of(body, star)) : distance;
  }

 private:
  template <bool kSwept>
  SOFTCD_HD bool is_certainly_spread(const VertexStar& star) const {
    constexpr int kMost = kMostTrianglesOfStar;
    if (star.ring[0] == kNoIndex) return false;
    StarMotion<kMost> motion;  // NOLINT(cppcoreguidelines-pro-type-member-init): set as far as it is read
    int count = 0;
    for (; count <= kMost && star.ring[count] != kNoIndex; ++count) {
      motion.t1[count] = scene.x_t1[star.ring[count]] - scene.x_t1[star.centre];
      motion.t0[count] = kSwept ? scene.x_t0[star.ring[count]] - scene.x_t0[star.centre] : motion.t1[count];
    }
    motion.triangle_count = count - 1;
    motion.is_closed = star.ring[count - 1] == star.ring[0];
    return softcd::is_certainly_spread<kSwept>(motion, distance_of(star));
  }

  SOFTCD_HD_SELDOM float rounding_of(const SceneBody& body, const VertexStar& star) const {
    float rounding = scene.vertex_rounding(body, star.centre);
    for (const std::uint32_t v : star.ring) {
      if (v != kNoIndex) rounding = larger(rounding, scene.vertex_rounding(body, v));
    }
    return rounding;
  }
};

/// Finds the triangles and edges that lie in stars that are spread out. All stars must have been tested.
struct FindSpreadParts {
  SceneView scene;
  SpreadParts spread;

  SOFTCD_HD void operator()(std::uint32_t t) const {
    const Ownership ownership = scene.ownership[t];
    if ((ownership & kLeftOut) != 0U) return;
    const auto& v = scene.triangles[t].v;
    const bool has_stars = scene.bodies[scene.triangle_body[t]].has_stars;
    const bool is_spread = has_stars && (spread.vertices[v[0]] & spread.vertices[v[1]] & spread.vertices[v[2]]) != 0U;
    spread.triangles[t] = is_spread ? 1 : 0;
    for (int side = 0; side < 3; ++side) {
      if ((ownership & (8U << side)) != 0U) spread.edges[scene.triangle_edges[t].e[side]] = is_spread ? 1 : 0;
    }
  }
};

/// Returns whether neighbours' features are known not to touch. Of two triangles with these features one vertex is
/// common. It is a corner of the triangle, or of both edges' owners. So its star has both.
template <ContactKind kKind>
SOFTCD_HD bool are_spread(const SpreadParts& spread, std::uint64_t features) {
  const std::uint32_t first = first_feature(features);
  const std::uint32_t second = second_feature(features);
  if constexpr (kKind == ContactKind::vertex_triangle) return spread.triangles[second] != 0U;
  return (spread.edges[first] | spread.edges[second]) != 0U;
}

}  // namespace softcd

#pragma once

#include <cstdint>
#include <type_traits>

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/grid/control_bits.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// ContactRule::slab reaches this many margins far: sqrt(5), rounded up.
constexpr float kSlabReach = 2.23606801F;

/// What the stages need to know of a body.
struct SceneBody {
  std::uint32_t id;
  std::uint32_t first_vertex, first_triangle, first_edge;
  float margin;
  bool vertex_triangle, edge_edge;
  /// The body touches itself, and the features of its triangles that share a vertex are on the scene's lists.
  bool lists_neighbours;
  /// Union of the volumes of all bodies that this one may touch, grown by their margins; empty when there are none.
  /// A triangle outside takes no part in the detection.
  Box reach;
};

/// All bodies concatenated in ascending order of ids; memory of the backend. Positions are float32, relative to the
/// scene's origin; x_t0 == x_t1 when nothing but the end of the step counts.
struct SceneView {
  const Vec3f* x_t0 = nullptr;
  const Vec3f* x_t1 = nullptr;
  const Triangle* triangles = nullptr;
  const Triangle* triangle_edges = nullptr;
  const Edge* edges = nullptr;
  const Ownership* ownership = nullptr;
  const std::uint32_t* triangle_body = nullptr;
  const std::uint32_t* vertex_body = nullptr;
  const SceneBody* bodies = nullptr;
  /// Symmetric bit matrix: bit b of row a says that a feature of body a may touch one of body b; a row is
  /// `pair_words` words long. The diagonal is self-collision.
  const std::uint32_t* may_touch = nullptr;
  std::uint32_t pair_words = 0;
  /// The same by body classes, body modulo kBodyClasses: bit b of word a says that some bodies of these classes may
  /// touch.
  std::uint32_t class_may_touch[kBodyClasses] = {};
  std::uint32_t vertex_count = 0;
  std::uint32_t triangle_count = 0;
  std::uint32_t edge_count = 0;
  std::uint32_t body_count = 0;
  bool is_swept = false;         ///< some vertex moves, and what lies on its way counts
  bool self_collision = false;   ///< some body may touch itself
  bool is_conservative = false;  ///< Accuracy::conservative
  /// See PipelineOptions::motion_margin.
  float motion_margin = 0.0F;
  /// Of a discrete detection.
  ContactRule contact_rule = ContactRule::distance;

  SOFTCD_HD bool bodies_may_touch(std::uint32_t a, std::uint32_t b) const {
    return ((may_touch[static_cast<std::size_t>(a) * pair_words + (b >> 5)] >> (b & 31U)) & 1U) != 0U;
  }

  /// Fills class_may_touch and self_collision from a host copy of the matrix; pair_words and body_count must be set.
  void summarize_pairs(Span<const std::uint32_t> host_may_touch) {
    for (std::uint32_t& word : class_may_touch) word = 0;
    self_collision = false;
    for (std::uint32_t body = 0; body < body_count; ++body) {
      const std::uint32_t diagonal = host_may_touch[static_cast<std::size_t>(body) * pair_words + (body >> 5)];
      self_collision |= ((diagonal >> (body & 31U)) & 1U) != 0U;
      for (std::uint32_t word = 0; word < pair_words; ++word) {
        class_may_touch[body % kBodyClasses] |= host_may_touch[static_cast<std::size_t>(body) * pair_words + word];
      }
    }
  }

  /// The distance within which features with this margin can be in contact.
  SOFTCD_HD float contact_reach(float margin) const {
    return contact_rule == ContactRule::slab ? outward_up(kSlabReach * margin) : margin;
  }

  /// The vertex's margin, grown by its motion, computed in T. In float the growth is a millionth too large, so that the
  /// roundings of all but the sum cannot make it too small.
  template <class T>
  SOFTCD_HD T vertex_margin(std::uint32_t v) const {
    const auto margin = static_cast<T>(bodies[vertex_body[v]].margin);
    if (!(motion_margin > 0.0F)) return margin;
    constexpr T kExcess = std::is_same_v<T, float> ? T(1.000001) : T(1);
    const T moved = kExcess * length(vec3_cast<T>(x_t1[v]) - vec3_cast<T>(x_t0[v]));
    return margin + static_cast<T>(motion_margin) * moved;
  }
};

/// A triangle's corners at both ends of the step.
using TriangleMotion = PointMotion<3>;

SOFTCD_HD inline TriangleMotion load_triangle(const SceneView& scene, std::uint32_t t) {
  const Triangle triangle = scene.triangles[t];
  TriangleMotion motion{};
  for (int corner = 0; corner < 3; ++corner) {
    motion.t1[corner] = scene.x_t1[triangle.v[corner]];
    motion.t0[corner] = scene.is_swept ? scene.x_t0[triangle.v[corner]] : motion.t1[corner];
  }
  return motion;
}

}  // namespace softcd

#pragma once

#include <cfloat>
#include <cstdint>
#include <type_traits>

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/grid/control_bits.hpp"
#include "softcd/math/box.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/math/separation.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/mesh/triangle_edges.hpp"

namespace softcd {

/// A pair in contact by ContactRule::slab is at most this many margins apart: sqrt(5), rounded up.
constexpr float kSlabFactor = 2.23606801F;

/// A body's data for the stages.
struct SceneBody {
  std::uint32_t id;
  std::uint32_t first_vertex, first_triangle, first_edge;
  float margin;
  bool vertex_triangle, edge_edge;
  /// Whether the body touches itself, and the scene's lists hold the features of its triangles that share a vertex.
  bool lists_neighbours;
  /// Union of the volumes of all bodies that this one may touch, grown by their margins; empty when there are none. A
  /// triangle outside of it takes no part in the detection.
  Box partner_box;
  /// Offset of the cells of the body's batch, see moved_cell. It separates batches in the grid, wherever they are.
  std::uint32_t cell_offset = 0;
  /// Exclusions within the body. `excludes_rings` leaves out features that the scene's rings say are near each other on
  /// the mesh. `rest_distance` leaves out features that are at most this far apart in the rest positions (0: none).
  bool excludes_rings = false;
  float rest_distance = 0.0F;
  /// Whether the detection compensates the rounding of the body's positions, and some position was rounded.
  bool is_rounded = false;
  /// Whether the body lists_neighbours, and the scene has the stars of all vertices of its triangles.
  bool has_stars = false;
};

/// Filters for features, apart from their positions. A pointer is null where no body has such a filter.
struct FeatureFilters {
  const VertexFilter* vertices = nullptr;
  /// Other vertices near vertex v on its mesh, ascending: ring_vertices[ring_begin[v]] up to, but without,
  /// ring_vertices[ring_begin[v + 1]].
  const std::uint64_t* ring_begin = nullptr;
  const std::uint32_t* ring_vertices = nullptr;
  /// Rest positions, each body relative to a point of its own.
  const Vec3f* x_rest = nullptr;
  bool are_set = false;  ///< some body of the detection has a filter

  friend bool operator==(const FeatureFilters&, const FeatureFilters&) = default;
};

/// Bounds the distance between a position and its float32, relative to the scene's origin. Each coordinate has an error
/// of at most 2^-24 of the float, and a far smaller one from the subtraction of the origin. The bound is sqrt(3) 2^-24,
/// plus an allowance for its own roundings and for denormalized floats.
SOFTCD_HD inline float rounding_bound(const Vec3f& rounded) {
  constexpr float kLargestShare = 1.75F * 0x1p-24F;
  return kLargestShare * max_norm(rounded) + FLT_MIN;
}

/// Triangles of a patch, which has one box and one set of cells. With 8 triangles, a recorded cloth on a ball has an
/// eighth of the entries of single triangles, and a tenth of the tests in cells.
constexpr std::uint32_t kPatchSize = 8;

/// All bodies concatenated in ascending order of ids, in the backend's memory. Positions are float32, relative to the
/// scene's origin. x_t0 == x_t1 when only one end of the step matters.
struct SceneView {
  const Vec3f* x_t0 = nullptr;
  const Vec3f* x_t1 = nullptr;
  /// The given positions in double. Null where the detection works on the floats, or where the floats are exact. Stages
  /// that reject pairs read floats, and allow for SceneBody::is_rounded. Stages that judge contacts read these.
  const Vec3d* full_t0 = nullptr;
  const Vec3d* full_t1 = nullptr;
  const Triangle* triangles = nullptr;
  const TriangleEdges* triangle_edges = nullptr;
  const Edge* edges = nullptr;
  const Ownership* ownership = nullptr;
  /// The triangles of patch p are patch_triangles[kPatchSize * p] and the following ones, all of one body. kNoIndex
  /// fills patches of fewer triangles. The first one is a triangle, unless there is none at all.
  const std::uint32_t* patch_triangles = nullptr;
  const std::uint32_t* triangle_body = nullptr;
  const std::uint32_t* vertex_body = nullptr;
  const SceneBody* bodies = nullptr;
  /// Pairs of bodies whose features may touch, each in both bodies' rows. A body that may touch itself is in its own
  /// row. Row a is partners[partner_begin[a]] up to, but without, partners[partner_begin[a + 1]], ascending.
  const std::uint64_t* partner_begin = nullptr;
  const std::uint32_t* partners = nullptr;
  FeatureFilters filters;
  /// The same pairs by body classes (body modulo kBodyClasses). Bit b of word a says that some bodies of these classes
  /// may touch.
  std::uint32_t class_may_touch[kBodyClasses] = {};
  std::uint32_t vertex_count = 0;
  std::uint32_t triangle_count = 0;
  std::uint32_t patch_count = 0;  ///< 0 if the broad phase has single triangles only
  std::uint32_t edge_count = 0;
  std::uint32_t body_count = 0;
  bool is_swept = false;         ///< some vertex moves, and the detection covers its path
  bool self_collision = false;   ///< some body may touch itself
  bool is_conservative = false;  ///< Accuracy::conservative
  bool has_batches = false;      ///< some body has a cell offset
  /// See QueryOptions::motion_margin.
  float motion_margin = 0.0F;
  /// The rule for contacts in a discrete detection.
  ContactRule contact_rule = ContactRule::distance;

  friend bool operator==(const SceneView&, const SceneView&) = default;

  /// The elements of the broad phase: the triangles, and behind them the patches.
  SOFTCD_HD std::uint32_t element_count() const { return triangle_count + patch_count; }
  SOFTCD_HD std::uint32_t patch_element(std::uint32_t patch) const { return triangle_count + patch; }
  SOFTCD_HD bool is_patch(std::uint32_t element) const { return element >= triangle_count; }
  /// Returns triangle i of a patch, kNoIndex if it has fewer; of a triangle, itself.
  SOFTCD_HD std::uint32_t element_triangle(std::uint32_t element, std::uint32_t i) const {
    return is_patch(element) ? patch_triangles[kPatchSize * (element - triangle_count) + i] : element;
  }
  SOFTCD_HD std::uint32_t element_body(std::uint32_t element) const {
    return triangle_body[element_triangle(element, 0)];
  }

  /// Returns the offset of this body's cells.
  SOFTCD_HD std::uint32_t cell_offset(std::uint32_t body) const { return has_batches ? bodies[body].cell_offset : 0U; }

  /// Returns whether features of the two bodies may touch. Searches the shorter of the two rows.
  SOFTCD_HD bool bodies_may_touch(std::uint32_t a, std::uint32_t b) const {
    const bool swap = partner_begin[b + 1] - partner_begin[b] < partner_begin[a + 1] - partner_begin[a];
    const std::uint32_t row = swap ? b : a;
    const std::uint32_t wanted = swap ? a : b;
    const std::uint64_t end = partner_begin[row + 1];
    std::uint64_t first = partner_begin[row];
    std::uint64_t last = end;
    while (first < last) {
      const std::uint64_t middle = first + (last - first) / 2;
      if (partners[middle] < wanted) {
        first = middle + 1;
      } else {
        last = middle;
      }
    }
    return first < end && partners[first] == wanted;
  }

  /// Fills class_may_touch and self_collision from a host copy of the rows; body_count must be set.
  void summarize_pairs(Span<const std::uint64_t> host_partner_begin, Span<const std::uint32_t> host_partners) {
    for (std::uint32_t& word : class_may_touch) word = 0;
    self_collision = false;
    for (std::uint32_t body = 0; body < body_count; ++body) {
      for (std::uint64_t i = host_partner_begin[body]; i < host_partner_begin[body + 1]; ++i) {
        class_may_touch[body % kBodyClasses] |= 1U << (host_partners[i] % kBodyClasses);
        self_collision |= host_partners[i] == body;
      }
    }
  }

  /// Returns whether floats suffice to reject contacts by ContactRule::slab. They do not suffice for rounded positions:
  /// rounding may turn the plane of a small triangle by any angle.
  SOFTCD_HD bool has_certain_slabs() const { return contact_rule == ContactRule::slab && full_t1 == nullptr; }

  /// Returns whether contacts must lie ahead: see ContactRule::ahead. Without a motion margin all do.
  SOFTCD_HD bool looks_ahead() const { return contact_rule == ContactRule::ahead && motion_margin > 0.0F; }

  /// Returns the distance within which features with this margin can be in contact.
  SOFTCD_HD float contact_distance(float margin) const {
    return contact_rule == ContactRule::slab ? outward_up(kSlabFactor * margin) : margin;
  }

  /// Returns positions of type T. In double, these are the given positions where they are known.
  template <class T>
  SOFTCD_HD Vec3<T> position_t0(std::uint32_t v) const {
    return position<T>(x_t0, full_t0, v);
  }
  template <class T>
  SOFTCD_HD Vec3<T> position_t1(std::uint32_t v) const {
    return position<T>(x_t1, full_t1, v);
  }

  /// Bounds the distance between the vertex's given and float32 positions at any time of the step.
  SOFTCD_HD float vertex_rounding(const SceneBody& body, std::uint32_t v) const {
    if (!body.is_rounded) return 0.0F;
    const float at_t1 = rounding_bound(x_t1[v]);
    return is_swept ? larger(at_t1, rounding_bound(x_t0[v])) : at_t1;
  }

  /// Returns the vertex's margin, grown by its motion, computed in T. In float the growth is a millionth too large, so
  /// that roundings (except the sum's) cannot make it too small.
  template <class T>
  SOFTCD_HD T vertex_margin(std::uint32_t v) const {
    const SceneBody& body = bodies[vertex_body[v]];
    const auto margin = static_cast<T>(body.margin);
    if (!(motion_margin > 0.0F)) return margin;
    if constexpr (std::is_same_v<T, float>) {
      float moved = length(x_t1[v] - x_t0[v]);
      if (body.is_rounded) moved += rounding_bound(x_t0[v]) + rounding_bound(x_t1[v]);
      return margin + motion_margin * (1.000001F * moved);
    } else {
      return margin + static_cast<T>(motion_margin) * length(position_t1<T>(v) - position_t0<T>(v));
    }
  }

 private:
  template <class T>
  static SOFTCD_HD Vec3<T> position(const Vec3f* x, const Vec3d* full, std::uint32_t v) {
    if constexpr (std::is_same_v<T, double>) {
      if (full != nullptr) return full[v];
    }
    return vec3_cast<T>(x[v]);
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

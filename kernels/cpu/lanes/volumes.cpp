#include "lanes/volumes.hpp"

#include <algorithm>

#include "lanes/targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lanes/volumes.cpp"  // NOLINT(readability-identifier-naming): Highway wants it
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/vectors-inl.hpp"

// Compiled once for each kind of processor, in a namespace of its own.
HWY_BEFORE_NAMESPACE();
namespace softcd::cpu::HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

void bound_range(const BoundTriangle& bound, std::uint32_t begin, std::uint32_t end) {
  for (std::uint32_t t = begin; t < end; ++t) bound(t);
}

#else

/// The volumes of as many triangles as registers have lanes: the lower bounds along all axes, then the upper ones.
struct Volumes {
  Float of[2 * kKdopAxes];

  HWY_INLINE Float& lo(int axis) { return of[axis]; }
  HWY_INLINE Float& hi(int axis) { return of[kKdopAxes + axis]; }
  HWY_INLINE const Float& lo(int axis) const { return of[axis]; }
  HWY_INLINE const Float& hi(int axis) const { return of[kKdopAxes + axis]; }

  HWY_INLINE Vector diagonal() const { return {hn::Sub(hi(0), lo(0)), hn::Sub(hi(1), lo(1)), hn::Sub(hi(2), lo(2))}; }
};

/// The corners of as many triangles as registers have lanes.
struct Corners {
  Vector of[3];

  HWY_INLINE Corners(const BoundTriangle& bound, const Vec3f* x, std::uint32_t first)
      : of{load_corner(bound, x, first, 0), load_corner(bound, x, first, 1), load_corner(bound, x, first, 2)} {}

 private:
  static HWY_INLINE Vector load_corner(const BoundTriangle& bound, const Vec3f* x, std::uint32_t first, int corner) {
    const Triangle* const triangles = bound.scene.triangles + first;
    return load([&](std::size_t i) -> const Vec3f& { return x[triangles[i].v[corner]]; });
  }
};

template <int kAxis>
HWY_INLINE Float lowest(const Corners& corners) {
  return smaller(smaller(project<kAxis>(corners.of[0]), project<kAxis>(corners.of[1])), project<kAxis>(corners.of[2]));
}
template <int kAxis>
HWY_INLINE Float highest(const Corners& corners) {
  return larger(larger(project<kAxis>(corners.of[0]), project<kAxis>(corners.of[1])), project<kAxis>(corners.of[2]));
}

HWY_INLINE Volumes volumes_of(const Corners& corners) {
  return {{lowest<0>(corners), lowest<1>(corners), lowest<2>(corners), lowest<3>(corners), lowest<4>(corners),
           lowest<5>(corners), lowest<6>(corners), lowest<7>(corners), lowest<8>(corners), highest<0>(corners),
           highest<1>(corners), highest<2>(corners), highest<3>(corners), highest<4>(corners), highest<5>(corners),
           highest<6>(corners), highest<7>(corners), highest<8>(corners)}};
}

HWY_INLINE Float furthest_coordinates(const Volumes& volumes) {
  Float furthest = hn::Zero(Floats());
  for (int axis = 0; axis < 3; ++axis) {
    furthest = larger(furthest, larger(hn::Abs(volumes.lo(axis)), hn::Abs(volumes.hi(axis))));
  }
  return furthest;
}

/// Grows volumes by balls of these radii. A radius of 0 changes nothing.
HWY_INLINE void inflate(Volumes& volumes, Float radius) {
  const Floats floats;
  const Mask grows = hn::Gt(radius, hn::Zero(floats));
  if (hn::AllFalse(floats, grows)) return;
  const Float diagonal = hn::Add(outward_up(hn::Mul(radius, all(1.41421357F))),
                                 hn::Mul(all(kCoordinateError), furthest_coordinates(volumes)));
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    const Float growth = axis < 3 ? radius : diagonal;
    Float& lo = volumes.lo(axis);
    Float& hi = volumes.hi(axis);
    lo = hn::IfThenElse(grows, outward_down(hn::Sub(lo, growth)), lo);
    hi = hn::IfThenElse(grows, outward_up(hn::Add(hi, growth)), hi);
  }
}

HWY_INLINE Volumes merged(const Volumes& a, const Volumes& b) {
  Volumes both = a;
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    both.lo(axis) = smaller(a.lo(axis), b.lo(axis));
    both.hi(axis) = larger(a.hi(axis), b.hi(axis));
  }
  return both;
}

HWY_INLINE Float bounding_radius(const Vector& diagonal) {
  return outward_up(hn::Mul(all(0.5F), norm(diagonal)));
}

/// Stores a block of four lanes of every register's block b at out(4 b).
template <class Tag, class Out>
HWY_INLINE void store_blocks(Tag tag, hn::Vec<Tag> values, std::size_t first, const Out& out) {
  if constexpr (hn::MaxLanes(Tag()) == 4) {
    hn::StoreU(values, tag, out(first));
  } else {
    const hn::Half<Tag> half;
    store_blocks(half, hn::LowerHalf(half, values), first, out);
    store_blocks(half, hn::UpperHalf(half, values), first + hn::MaxLanes(half), out);
  }
}

/// Stores four values of each triangle t at out(t).
template <class Out>
HWY_INLINE void store_fours(const Four& columns, const Out& out) {
  const Four rows = transposed(columns);
  for (std::size_t row = 0; row < 4; ++row) store_blocks(Floats(), rows.of[row], row, out);
}

HWY_INLINE void store(const Volumes& volumes, Kdop18* out) {
  static_assert(sizeof(Kdop18) >= 2 * kKdopAxes * sizeof(float));
  // The last four values overlap those before.
  for (const std::size_t at : {0U, 4U, 8U, 12U, 14U}) {
    const Float* const of = volumes.of + at;
    store_fours({{of[0], of[1], of[2], of[3]}}, [&](std::size_t t) { return out[t].lo + at; });
  }
}

HWY_INLINE void store(const Volumes& t0, const Volumes& t1, EndVolumes* out) {
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    store_fours({{t0.lo(axis), t0.hi(axis), t1.lo(axis), t1.hi(axis)}},
                [&](std::size_t t) { return &out[t].axes[axis].t0_lo; });
  }
}

/// Does the same as BoundTriangle::growth_of for triangles of one body whose positions are not rounded. Returns false
/// if a motion is too long or too short for this.
template <bool kSwept>
HWY_INLINE bool find_growth(const BoundTriangle& bound, const SceneBody& body, const Corners& at_t1,
                            std::uint32_t first, Float& growth) {
  const SceneView& scene = bound.scene;
  growth = all(body.margin);
  if (!kSwept && scene.motion_margin > 0.0F) {
    const Corners at_t0(bound, scene.x_t0, first);
    for (int corner = 0; corner < 3; ++corner) {
      const Vector motion = at_t1.of[corner] - at_t0.of[corner];
      if (!are_ordinary(max_norm(motion))) return false;
      const Float moved = hn::Mul(all(1.000001F), norm(motion));
      growth = larger(growth, outward_up(hn::Add(all(body.margin), hn::Mul(all(scene.motion_margin), moved))));
    }
  }
  if (scene.contact_rule == ContactRule::slab) growth = outward_up(hn::Mul(all(kSlabFactor), growth));
  return true;
}

HWY_INLINE bool are_of_one_body(const SceneView& scene, std::uint32_t first) {
  const std::uint32_t* const bodies = scene.triangle_body + first;
  return std::all_of(bodies, bodies + kLanes, [&](std::uint32_t body) { return body == bodies[0]; });
}

/// Returns the triangles whose volumes are out of the box.
HWY_INLINE Mask are_out_of(const Box& box, const Volumes& volumes) {
  const auto are_out_along = [&](int axis) {
    return hn::Or(hn::Lt(all(box.hi[axis]), volumes.lo(axis)), hn::Lt(volumes.hi(axis), all(box.lo[axis])));
  };
  return hn::Or(hn::Or(are_out_along(0), are_out_along(1)), are_out_along(2));
}

/// Bounds as many triangles as registers have lanes. Returns false, and has done nothing, if they have to be bounded
/// one by one.
template <bool kSwept>
HWY_INLINE bool bound_register(const BoundTriangle& bound, std::uint32_t first) {
  const SceneView& scene = bound.scene;
  const Corners corners_t1(bound, scene.x_t1, first);
  Volumes at_t1 = volumes_of(corners_t1);
  Volumes at_t0 = kSwept ? volumes_of(Corners(bound, scene.x_t0, first)) : at_t1;
  const Vector diagonal_t1 = at_t1.diagonal();
  const Vector diagonal_t0 = at_t0.diagonal();
  if (!are_ordinary(max_norm(diagonal_t1)) || (kSwept && !are_ordinary(max_norm(diagonal_t0)))) return false;

  alignas(64) float growths[kLanes];
  alignas(64) float roundings[kLanes] = {};
  const SceneBody& body_of_first = scene.bodies[scene.triangle_body[first]];
  const bool is_one_body = are_of_one_body(scene, first);
  Float growth;
  if (is_one_body && !body_of_first.is_rounded &&
      find_growth<kSwept>(bound, body_of_first, corners_t1, first, growth)) {
    hn::Store(growth, Floats(), growths);
  } else {
    for (std::uint32_t i = 0; i < kLanes; ++i) {
      const BoundTriangle::Growth one = bound.growth_of(first + i, scene.bodies[scene.triangle_body[first + i]]);
      growths[i] = one.total;
      roundings[i] = one.rounding;
    }
    growth = hn::Load(Floats(), growths);
  }
  inflate(at_t1, growth);
  if (kSwept) inflate(at_t0, growth);
  const Volumes volumes = kSwept ? merged(at_t0, at_t1) : at_t1;
  if (is_one_body && hn::AllTrue(Floats(), are_out_of(body_of_first.partner_box, volumes))) {
    for (std::uint32_t i = 0; i < kLanes; ++i) bound.leave_out(first + i);
    return true;
  }
  store(volumes, bound.volumes + first);
  if (kSwept) store(at_t0, at_t1, bound.end_volumes + first);
  Float radius = bounding_radius(diagonal_t1);
  if (kSwept) radius = larger(radius, bounding_radius(diagonal_t0));
  alignas(64) float radii[kLanes];
  hn::Store(radius, Floats(), radii);
  for (std::uint32_t i = 0; i < kLanes; ++i) {
    const std::uint32_t t = first + i;
    const SceneBody& body = scene.bodies[scene.triangle_body[t]];
    bound.shapes[t] = {radii[i], growths[i], bound.flags_of(t, body), roundings[i]};
    if (!overlap(body.partner_box, bound.volumes[t])) bound.leave_out(t);
  }
  return true;
}

/// Bounds as many triangles as registers have lanes, at once if that is possible.
void bound_lanes(const BoundTriangle& bound, std::uint32_t first) {
  const SceneView& scene = bound.scene;
  bool has_left_out = false;
  for (std::uint32_t i = 0; i < kLanes; ++i) has_left_out |= (scene.ownership[first + i] & kLeftOut) != 0U;
  if (!has_left_out) {
    if (scene.is_swept ? bound_register<true>(bound, first) : bound_register<false>(bound, first)) return;
  }
  for (std::uint32_t i = 0; i < kLanes; ++i) bound(first + i);
}

void bound_range(const BoundTriangle& bound, std::uint32_t begin, std::uint32_t end) {
  std::uint32_t t = begin;
  for (; t + kLanes <= end; t += kLanes) bound_lanes(bound, t);
  for (; t < end; ++t) bound(t);
}

#endif

}  // namespace softcd::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace softcd::cpu {

HWY_EXPORT(bound_range);

void for_range(const BoundTriangle& bound, std::uint32_t begin, std::uint32_t end) {
  HWY_DYNAMIC_DISPATCH(bound_range)(bound, begin, end);
}

}  // namespace softcd::cpu
#endif

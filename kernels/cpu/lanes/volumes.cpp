#include "lanes/volumes.hpp"

#include <algorithm>
#include <bit>

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

  /// Leaves the values open. g++ for aarch64 compiles an implicit constructor without the options of these registers.
  HWY_INLINE Volumes() {}  // NOLINT(cppcoreguidelines-pro-type-member-init)
};

/// The bounds of triangles along one axis.
struct Interval {
  Float lo, hi;
};

/// The bounds of triangles along x, y and z.
struct Boxes {
  Interval along[3];

  HWY_INLINE Vector diagonal() const {
    return {hn::Sub(along[0].hi, along[0].lo), hn::Sub(along[1].hi, along[1].lo), hn::Sub(along[2].hi, along[2].lo)};
  }
  HWY_INLINE Float furthest_coordinate() const {
    Float furthest = hn::Zero(Floats());
    for (const Interval& interval : along) {
      furthest = larger(furthest, larger(hn::Abs(interval.lo), hn::Abs(interval.hi)));
    }
    return furthest;
  }
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
HWY_INLINE Interval interval(const Corners& corners) {
  const Float a = project<kAxis>(corners.of[0]);
  const Float b = project<kAxis>(corners.of[1]);
  const Float c = project<kAxis>(corners.of[2]);
  return {smaller(smaller(a, b), c), larger(larger(a, b), c)};
}

HWY_INLINE Boxes boxes_of(const Corners& corners) {
  return {{interval<0>(corners), interval<1>(corners), interval<2>(corners)}};
}

/// Grows volumes by balls, as softcd::inflate does. A radius of 0 changes nothing.
class Growing {
 public:
  HWY_INLINE explicit Growing(Float radius)
      : radius_(radius), grows_(hn::Gt(radius, hn::Zero(Floats()))), any_(!hn::AllFalse(Floats(), grows_)) {}

  /// Returns the growth along x, y and z.
  HWY_INLINE Float straight() const { return radius_; }
  /// Returns the growth along the diagonals.
  HWY_INLINE Float diagonal(const Boxes& boxes) const {
    return hn::Add(outward_up(hn::Mul(radius_, all(1.41421357F))),
                   hn::Mul(all(kCoordinateError), boxes.furthest_coordinate()));
  }
  HWY_INLINE Interval grown(const Interval& interval, Float growth) const {
    if (!any_) return interval;
    return {hn::IfThenElse(grows_, outward_down(hn::Sub(interval.lo, growth)), interval.lo),
            hn::IfThenElse(grows_, outward_up(hn::Add(interval.hi, growth)), interval.hi)};
  }
  HWY_INLINE Boxes grown(const Boxes& boxes) const {
    return {{grown(boxes.along[0], straight()), grown(boxes.along[1], straight()), grown(boxes.along[2], straight())}};
  }

 private:
  Float radius_;
  Mask grows_;
  bool any_;
};

HWY_INLINE Interval merged(const Interval& a, const Interval& b) {
  return {smaller(a.lo, b.lo), larger(a.hi, b.hi)};
}
HWY_INLINE Boxes merged(const Boxes& a, const Boxes& b) {
  return {{merged(a.along[0], b.along[0]), merged(a.along[1], b.along[1]), merged(a.along[2], b.along[2])}};
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

HWY_INLINE void store(const Interval& t0, const Interval& t1, int axis, EndVolumes* out, std::uint32_t first) {
  store_fours({{t0.lo, t0.hi, t1.lo, t1.hi}}, [&](std::size_t t) { return &out[first + t].axes[axis].t0_lo; });
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

/// Returns the triangles whose boxes are out of the body's.
HWY_INLINE Mask are_out_of(const Box& box, const Boxes& boxes) {
  const auto are_out_along = [&](int axis) {
    const Interval& interval = boxes.along[axis];
    return hn::Or(hn::Lt(all(box.hi[axis]), interval.lo), hn::Lt(interval.hi, all(box.lo[axis])));
  };
  return hn::Or(hn::Or(are_out_along(0), are_out_along(1)), are_out_along(2));
}

/// A register of triangles that are being bounded. Their corners at t0 count only if they are swept.
template <bool kSwept>
struct BoundedRegister {
  const Corners &t0, &t1;
  const Growing& growing;
  Float diagonal_t0, diagonal_t1;  ///< growths along the diagonals
  EndVolumes* end_volumes;         ///< null unless swept
  std::uint32_t first;
  Volumes& volumes;

  HWY_INLINE void bound_along(int axis, const Interval& at_t0, const Interval& at_t1) {
    if constexpr (kSwept) store(at_t0, at_t1, axis, end_volumes, first);
    const Interval both = kSwept ? merged(at_t0, at_t1) : at_t1;
    volumes.of[axis] = both.lo;
    volumes.of[kKdopAxes + axis] = both.hi;
  }
  template <int kAxis>
  HWY_INLINE void bound_along_diagonal() {
    const Interval at_t1 = growing.grown(interval<kAxis>(t1), diagonal_t1);
    const Interval at_t0 = kSwept ? growing.grown(interval<kAxis>(t0), diagonal_t0) : at_t1;
    bound_along(kAxis, at_t0, at_t1);
  }
};

/// Bounds as many triangles as registers have lanes. Their corners at t0 count only if they are swept. Returns false,
/// and has done nothing, if they have to be bounded one by one.
template <bool kSwept>
HWY_INLINE bool bound_register(const BoundTriangle& bound, std::uint32_t first, const Corners& t0, const Corners& t1) {
  const SceneView& scene = bound.scene;
  const Boxes tight_t1 = boxes_of(t1);
  const Boxes tight_t0 = kSwept ? boxes_of(t0) : tight_t1;
  const Vector diagonal_t1 = tight_t1.diagonal();
  const Vector diagonal_t0 = tight_t0.diagonal();
  if (!are_ordinary(max_norm(diagonal_t1)) || (kSwept && !are_ordinary(max_norm(diagonal_t0)))) return false;

  alignas(64) float growths[kLanes];
  alignas(64) float roundings[kLanes] = {};
  const SceneBody& body_of_first = scene.bodies[scene.triangle_body[first]];
  const bool is_one_body = are_of_one_body(scene, first);
  Float growth;
  if (is_one_body && !body_of_first.is_rounded && find_growth<kSwept>(bound, body_of_first, t1, first, growth)) {
    hn::Store(growth, Floats(), growths);
  } else {
    for (std::uint32_t i = 0; i < kLanes; ++i) {
      const BoundTriangle::Growth one = bound.growth_of(first + i, scene.bodies[scene.triangle_body[first + i]]);
      growths[i] = one.total;
      roundings[i] = one.rounding;
    }
    growth = hn::Load(Floats(), growths);
  }
  const Growing growing(growth);
  const Boxes at_t1 = growing.grown(tight_t1);
  const Boxes at_t0 = kSwept ? growing.grown(tight_t0) : at_t1;
  const Boxes boxes = kSwept ? merged(at_t0, at_t1) : at_t1;
  std::uint64_t out = 0;
  if (is_one_body) {
    const Mask are_out = are_out_of(body_of_first.partner_box, boxes);
    if (hn::AllTrue(Floats(), are_out)) {
      for (std::uint32_t i = 0; i < kLanes; ++i) bound.leave_out(first + i);
      return true;
    }
    out = bits_of(are_out);
  }

  Volumes volumes;
  BoundedRegister<kSwept> bounded{
      t0, t1, growing, growing.diagonal(tight_t0), growing.diagonal(tight_t1), bound.end_volumes, first, volumes};
  for (int axis = 0; axis < 3; ++axis) bounded.bound_along(axis, at_t0.along[axis], at_t1.along[axis]);
  bounded.template bound_along_diagonal<3>();
  bounded.template bound_along_diagonal<4>();
  bounded.template bound_along_diagonal<5>();
  bounded.template bound_along_diagonal<6>();
  bounded.template bound_along_diagonal<7>();
  bounded.template bound_along_diagonal<8>();
  store(volumes, bound.volumes + first);
  Float radius = bounding_radius(diagonal_t1);
  if (kSwept) radius = larger(radius, bounding_radius(diagonal_t0));
  alignas(64) float radii[kLanes];
  hn::Store(radius, Floats(), radii);
  for (std::uint32_t i = 0; i < kLanes; ++i) {
    const std::uint32_t t = first + i;
    const SceneBody& body = is_one_body ? body_of_first : scene.bodies[scene.triangle_body[t]];
    bound.shapes[t] = {radii[i], growths[i], bound.flags_of(t, body), roundings[i]};
    if (!is_one_body && !overlap(body.partner_box, bound.volumes[t])) bound.leave_out(t);
  }
  for (; out != 0; out &= out - 1) bound.leave_out(first + static_cast<std::uint32_t>(std::countr_zero(out)));
  return true;
}

template <bool kSwept>
HWY_INLINE bool bound_register(const BoundTriangle& bound, std::uint32_t first) {
  const Corners t1(bound, bound.scene.x_t1, first);
  if constexpr (kSwept) return bound_register<true>(bound, first, Corners(bound, bound.scene.x_t0, first), t1);
  return bound_register<false>(bound, first, t1, t1);
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

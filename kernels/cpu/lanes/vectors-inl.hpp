// Vectors of floats in registers, for the sources that are compiled once for each kind of processor: they include this
// file once for each. Each operation and its order are those of the functions of the same names in softcd, so that
// roundings are the same.
#if defined(SOFTCD_CPU_LANES_VECTORS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef SOFTCD_CPU_LANES_VECTORS_INL_HPP
#undef SOFTCD_CPU_LANES_VECTORS_INL_HPP
#else
#define SOFTCD_CPU_LANES_VECTORS_INL_HPP
#endif

#include <hwy/highway.h>

#include <cfloat>
#include <cstddef>
#include <cstdint>

#include "softcd/core/types.hpp"
#include "softcd/math/scalar.hpp"

HWY_BEFORE_NAMESPACE();
namespace softcd::cpu::HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Float = hn::Vec<Floats>;
using Mask = hn::Mask<Floats>;

constexpr std::size_t kLanes = hn::MaxLanes(Floats());

HWY_INLINE Float all(float x) {
  return hn::Set(Floats(), x);
}
HWY_INLINE Float smaller(Float a, Float b) {
#if HWY_ARCH_X86
  return hn::Min(a, b);
#else
  return hn::IfThenElse(hn::Lt(a, b), a, b);
#endif
}
template <class Vec>
HWY_INLINE Vec larger(Vec a, Vec b) {
#if HWY_ARCH_X86
  return hn::Max(a, b);
#else
  return hn::IfThenElse(hn::Gt(a, b), a, b);
#endif
}
HWY_INLINE Float outward_by(Float x) {
  return hn::Add(hn::Mul(hn::Abs(x), all(epsilon<float>())), all(FLT_MIN));
}
HWY_INLINE Float outward_down(Float x) {
  return hn::Sub(x, outward_by(x));
}
HWY_INLINE Float outward_up(Float x) {
  return hn::Add(x, outward_by(x));
}

/// Returns the lanes of the mask as bits.
HWY_INLINE std::uint64_t bits_of(Mask mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(Floats(), mask, bits);
  return bits[0] | (std::uint64_t{bits[1]} << 8);
}

struct Vector {
  Float x, y, z;
};

HWY_INLINE Vector operator-(const Vector& a, const Vector& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vector operator+(const Vector& a, const Vector& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vector operator*(Float factor, const Vector& a) {
  return {hn::Mul(factor, a.x), hn::Mul(factor, a.y), hn::Mul(factor, a.z)};
}
/// Returns a in the lanes of the mask, else b.
HWY_INLINE Vector chosen(Mask mask, const Vector& a, const Vector& b) {
  return {hn::IfThenElse(mask, a.x, b.x), hn::IfThenElse(mask, a.y, b.y), hn::IfThenElse(mask, a.z, b.z)};
}
HWY_INLINE Float dot(const Vector& a, const Vector& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vector cross(const Vector& a, const Vector& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Float norm(const Vector& a) {
  return hn::Sqrt(dot(a, a));
}
HWY_INLINE Float max_norm(const Vector& a) {
  return larger(larger(hn::Abs(a.x), hn::Abs(a.y)), hn::Abs(a.z));
}

/// Returns whether safe_scale() of all extents is 1.
HWY_INLINE bool are_ordinary(Float extent) {
  const Mask is_in_range = hn::And(hn::Ge(extent, all(0x1p-16F)), hn::Le(extent, all(0x1p+28F)));
  return hn::AllTrue(Floats(), hn::Or(is_in_range, hn::Not(hn::Gt(extent, hn::Zero(Floats())))));
}

/// Returns the projection onto an axis of Kdop18.
template <int kAxis>
HWY_INLINE Float project(const Vector& p) {
  if constexpr (kAxis < 3) {
    return kAxis == 0 ? p.x : (kAxis == 1 ? p.y : p.z);
  } else {
    const Float first = kAxis == 5 || kAxis == 8 ? p.y : p.x;
    const Float second = kAxis == 3 || kAxis == 6 ? p.y : p.z;
    return kAxis < 6 ? hn::Add(first, second) : hn::Sub(first, second);
  }
}

/// Returns x, y, y, z of every fourth point, one in each block of four lanes. point_of(i) returns the i-th point. Reads
/// nothing beyond the points.
template <class Tag, class PointOf>
HWY_INLINE hn::Vec<Tag> rows(Tag tag, const PointOf& point_of, std::size_t first) {
  if constexpr (hn::MaxLanes(Tag()) == 4) {
    const hn::FixedTag<float, 2> two;
    const Vec3f& point = point_of(first);
    return hn::Combine(tag, hn::LoadU(two, &point.y), hn::LoadU(two, &point.x));
  } else {
    const hn::Half<Tag> half;
    return hn::Combine(tag, rows(half, point_of, first + hn::MaxLanes(half)), rows(half, point_of, first));
  }
}

/// Four registers, as rows of their blocks of four lanes or as columns.
struct Four {
  Float of[4];
};

/// Transposes each block of four lanes.
HWY_INLINE Four transposed(const Four& four) {
  const Floats floats;
  const hn::RepartitionToWide<Floats> twos;
  const auto lower01 = hn::BitCast(twos, hn::InterleaveLower(floats, four.of[0], four.of[1]));
  const auto lower23 = hn::BitCast(twos, hn::InterleaveLower(floats, four.of[2], four.of[3]));
  const auto upper01 = hn::BitCast(twos, hn::InterleaveUpper(floats, four.of[0], four.of[1]));
  const auto upper23 = hn::BitCast(twos, hn::InterleaveUpper(floats, four.of[2], four.of[3]));
  return {{hn::BitCast(floats, hn::InterleaveLower(twos, lower01, lower23)),
           hn::BitCast(floats, hn::InterleaveUpper(twos, lower01, lower23)),
           hn::BitCast(floats, hn::InterleaveLower(twos, upper01, upper23)),
           hn::BitCast(floats, hn::InterleaveUpper(twos, upper01, upper23))}};
}

/// Loads as many points as registers have lanes.
template <class PointOf>
HWY_INLINE Vector load(const PointOf& point_of) {
  const Floats floats;
  const Four columns = transposed(
      {{rows(floats, point_of, 0), rows(floats, point_of, 1), rows(floats, point_of, 2), rows(floats, point_of, 3)}});
  return {columns.of[0], columns.of[1], columns.of[3]};
}

#endif
}  // namespace softcd::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

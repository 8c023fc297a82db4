#pragma once

#include <cmath>

#include "softcd/core/host_device.hpp"
#include "softcd/grid/cell_index.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/math/simd.hpp"

namespace softcd {

/// Coordinates (in cells) beyond which a triangle is not put into the grid: below it every integer and every sum
/// of two is exact in float32.
constexpr float kGridExtent = 1048576.0F;  // 2^20

/// Returns the cell that holds `point`; `inverse_size` is 1 / s, and a fraction rounds down on both sides of zero.
SOFTCD_HD inline Cell cell_of(Vec3f point, float inverse_size) {
  return {static_cast<int>(floorf(point.x * inverse_size)), static_cast<int>(floorf(point.y * inverse_size)),
          static_cast<int>(floorf(point.z * inverse_size))};
}

struct CellInterval {
  int lo, hi;

  SOFTCD_HD constexpr bool empty() const { return hi < lo; }
  SOFTCD_HD constexpr bool contains(int i) const { return lo <= i && i <= hi; }
};

/// An 18-DOP on the integer lattice: the cells (x, y, z) whose coordinates, sums and differences lie in nine integer
/// intervals. It contains every cell that a real point of the 18-DOP falls into.
struct IntegerDop {
  int lo[kKdopAxes];
  int hi[kKdopAxes];

  /// Returns the cells along y that may be non-empty in layer z.
  SOFTCD_HD constexpr CellInterval column(int z) const {
    return {larger(lo[1], larger(lo[5] - z, lo[8] + z)), smaller(hi[1], smaller(hi[5] - z, hi[8] + z))};
  }

  /// Returns the cells along x in row (y, z); empty if the row is outside.
  SOFTCD_HD constexpr CellInterval row(int y, int z) const {
    const bool inside = lo[1] <= y && y <= hi[1] && lo[2] <= z && z <= hi[2] && lo[5] <= y + z && y + z <= hi[5] &&
                        lo[8] <= y - z && y - z <= hi[8];
    if (!inside) return {0, -1};
    return {larger(lo[0], larger(larger(lo[3] - y, lo[4] - z), larger(lo[6] + y, lo[7] + z))),
            smaller(hi[0], smaller(smaller(hi[3] - y, hi[4] - z), smaller(hi[6] + y, hi[7] + z)))};
  }

  SOFTCD_HD constexpr bool contains(Cell cell) const { return row(cell.y, cell.z).contains(cell.x); }

  /// Returns the number of cells along the longest of x, y, z.
  SOFTCD_HD constexpr int span() const { return 1 + larger(hi[0] - lo[0], larger(hi[1] - lo[1], hi[2] - lo[2])); }
};

/// Whether every projection of the volume lies within kGridExtent cells of the origin.
SOFTCD_HD inline bool within_grid(const Kdop18& dop, float inverse_size) {
  const float furthest = furthest_coordinate(dop);
  return furthest * inverse_size <= kGridExtent;
}

namespace detail {

/// Returns a bound on the roundings of a projection onto a diagonal and of its scaling, in cells.
SOFTCD_HD inline float projection_slack(const Kdop18& dop, float inverse_size) {
  return kCoordinateError * furthest_coordinate(dop) * inverse_size;
}

#ifdef SOFTCD_SSE2
/// Returns the floor of numbers that an int holds.
inline __m128i floor_of(__m128 x) {
  const __m128i truncated = _mm_cvttps_epi32(x);
  // All bits set, -1, where truncation went up.
  return _mm_add_epi32(truncated, _mm_castps_si128(_mm_cmplt_ps(x, _mm_cvtepi32_ps(truncated))));
}

inline void store(int* out, __m128i x) {
  _mm_storeu_si128(reinterpret_cast<__m128i*>(out), x);
}
#endif

}  // namespace detail

namespace generic {
SOFTCD_HD inline IntegerDop integer_dop(const Kdop18& dop, float inverse_size) {
  const float slack = detail::projection_slack(dop, inverse_size);
  IntegerDop cells{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    const float pad = axis < 3 ? 0.0F : slack;
    cells.lo[axis] = static_cast<int>(floorf(dop.lo[axis] * inverse_size - pad)) - (axis >= 3 && axis < 6 ? 1 : 0);
    cells.hi[axis] = static_cast<int>(floorf(dop.hi[axis] * inverse_size + pad)) + (axis >= 6 ? 1 : 0);
  }
  return cells;
}
}  // namespace generic

/// Returns the cells of an 18-DOP that is within_grid().
///
/// With u = p / s and i = floor(u): x, y and z are scaled and floored monotonely, so touching volumes share a cell
/// without padding. For a sum, u_x + u_y - 2 < i + j <= u_x + u_y; for a difference,
/// u_x - u_y - 1 < i - j < u_x - u_y + 1.
SOFTCD_HD inline IntegerDop integer_dop(const Kdop18& dop, float inverse_size) {
#ifdef SOFTCD_SSE2
  const float slack = detail::projection_slack(dop, inverse_size);
  const __m128 scale = _mm_set1_ps(inverse_size);
  IntegerDop cells;  // NOLINT(cppcoreguidelines-pro-type-member-init): written below
  // The axes from 5 on, read and written last, overlap those from 4 on.
  const auto round = [&](int axis, __m128 pads, __m128i below, __m128i above) {
    const __m128 lo = _mm_sub_ps(_mm_mul_ps(_mm_loadu_ps(dop.lo + axis), scale), pads);
    const __m128 hi = _mm_add_ps(_mm_mul_ps(_mm_loadu_ps(dop.hi + axis), scale), pads);
    detail::store(cells.lo + axis, _mm_sub_epi32(detail::floor_of(lo), below));
    detail::store(cells.hi + axis, _mm_add_epi32(detail::floor_of(hi), above));
  };
  const __m128 slacks = _mm_set1_ps(slack);
  round(0, _mm_setr_ps(0.0F, 0.0F, 0.0F, slack), _mm_setr_epi32(0, 0, 0, 1), _mm_setzero_si128());
  round(4, slacks, _mm_setr_epi32(1, 1, 0, 0), _mm_setr_epi32(0, 0, 1, 1));
  round(5, slacks, _mm_setr_epi32(1, 0, 0, 0), _mm_setr_epi32(0, 1, 1, 1));
  return cells;
#else
  return generic::integer_dop(dop, inverse_size);
#endif
}

}  // namespace softcd

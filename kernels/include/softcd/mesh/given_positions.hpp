#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/coordinate_range.hpp"
#include "softcd/math/exact_sum.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// The caller's positions: three consecutive floats or doubles each, `stride` bytes apart, in the memory of the host or
/// of a device.
struct GivenPositions {
  const void* data = nullptr;
  std::uint64_t stride = 0;
  bool is_double = false;
};

/// The vertices [begin, end) of one body, which a survey scans for extents and motion.
struct SurveyedVertices {
  GivenPositions x_t0, x_t1;
  std::uint64_t begin, end;
  bool has_two_ends;  ///< x_t0 is not x_t1
};

/// The smallest box around points.
struct Extent {
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  Vec3d lo{kInfinity, kInfinity, kInfinity}, hi{-kInfinity, -kInfinity, -kInfinity};

  SOFTCD_HD bool is_empty() const { return lo.x > hi.x; }
  SOFTCD_HD_SHORT void extend(const Vec3d& low, const Vec3d& high) {
    lo = {smaller(low.x, lo.x), smaller(low.y, lo.y), smaller(low.z, lo.z)};
    hi = {larger(high.x, hi.x), larger(high.y, hi.y), larger(high.z, hi.z)};
  }
  SOFTCD_HD void extend(const Vec3d& p) { extend(p, p); }
  SOFTCD_HD void extend(const Extent& other) { extend(other.lo, other.hi); }
};

/// Summary of the positions at one end of a body's step.
struct EndSurvey {
  Extent extent;                  ///< of the vertices that are finite
  std::uint32_t stray_count = 0;  ///< number of vertices that are not finite
  bool is_rounded = false;        ///< some vertex differs from its float32 in the scene

  SOFTCD_HD void merge(const EndSurvey& other) {
    extent.extend(other.extent);
    stray_count += other.stray_count;
    is_rounded |= other.is_rounded;
  }
};

/// Summary of the positions at both ends.
struct StepSurvey {
  EndSurvey t0, t1;
  double squared_move = 0;  ///< largest distance between a vertex's two ends
  bool moves = false;       ///< some vertex has different positions at t0 and t1

  SOFTCD_HD void merge(const StepSurvey& other) {
    t0.merge(other.t0);
    t1.merge(other.t1);
    squared_move = larger(squared_move, other.squared_move);
    moves |= other.moves;
  }
};

/// Returns a vertex's position. T is the type of its coordinates.
template <class T>
SOFTCD_HD Vec3d position_at(const GivenPositions& positions, std::uint64_t vertex) {
  const auto* const x =
      reinterpret_cast<const T*>(static_cast<const std::byte*>(positions.data) + vertex * positions.stride);
  return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
}

/// Returns whether float32 rounds x relative to the origin.
SOFTCD_HD inline bool is_rounded(double x, double origin) {
  const DoubleDouble relative = exact_difference(x, origin);
  // g++ 12 forgets to round where it vectorises the conversion to and fro.
  const volatile float rounded = static_cast<float>(relative.hi);
  return !(static_cast<double>(rounded) == relative.hi && relative.lo == 0.0);
}

/// Returns the position relative to the scene's origin, as float32; NaN where it is not finite. Floats lose nothing,
/// see origin_of.
SOFTCD_HD inline Vec3f placed(const Vec3d& x, const Vec3d& origin) {
  return is_usable(x) ? vec3_cast<float>(x - origin) : Vec3f{NAN, NAN, NAN};
}

/// Writes a vertex's position for the scene: as a float relative to the origin, or in double. T is the type of the
/// given coordinates.
template <class T, class Out>
struct PlacePosition {
  GivenPositions positions;
  Vec3d origin;
  Out* out;

  SOFTCD_HD void operator()(std::uint64_t vertex) const {
    const Vec3d x = position_at<T>(positions, vertex);
    if constexpr (std::is_same_v<Out, Vec3d>) {
      out[vertex] = x;
    } else {
      out[vertex] = placed(x, origin);
    }
  }
};

SOFTCD_HD_SHORT void survey_end(const Vec3d& x, EndSurvey& survey) {
  if (is_usable(x)) {
    survey.extent.extend(x);
  } else {
    ++survey.stray_count;
  }
}

/// Records whether placing the position rounds it. T is the type of the given coordinates; floats are never rounded.
template <class T>
SOFTCD_HD void survey_rounding(const Vec3d& x, const Vec3d& origin, EndSurvey& survey) {
  if constexpr (std::is_same_v<T, double>) {
    if (survey.is_rounded || !is_usable(x)) return;
    survey.is_rounded = is_rounded(x.x, origin.x) || is_rounded(x.y, origin.y) || is_rounded(x.z, origin.z);
  }
}

SOFTCD_HD_SHORT void survey_way(const Vec3d& x_t0, const Vec3d& x_t1, StepSurvey& survey) {
  if (!is_usable(x_t0) || !is_usable(x_t1)) return;
  survey.moves |= !(x_t0 == x_t1);
  survey.squared_move = larger(survey.squared_move, squared_norm(x_t1 - x_t0));
}

/// Scans one vertex at both ends of the step. Skips t0 where it equals t1, or is not needed.
template <class T>
SOFTCD_HD_SHORT void survey_vertex(const SurveyedVertices& vertices, std::uint64_t vertex, const Vec3d& origin,
                                   bool needs_t0, StepSurvey& survey) {
  const Vec3d x_t1 = position_at<T>(vertices.x_t1, vertex);
  survey_end(x_t1, survey.t1);
  survey_rounding<T>(x_t1, origin, survey.t1);
  if (!vertices.has_two_ends || !needs_t0) return;
  const Vec3d x_t0 = position_at<T>(vertices.x_t0, vertex);
  survey_end(x_t0, survey.t0);
  survey_rounding<T>(x_t0, origin, survey.t0);
  survey_way(x_t0, x_t1, survey);
}

}  // namespace softcd

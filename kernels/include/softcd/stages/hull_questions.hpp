#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/spatial_query.hpp"

namespace softcd {

/// A hull, whose points are a part of all hulls' points; see ProbeHull.
struct HullQuestion {
  std::uint32_t first_point, point_count;
  double radius;
};

/// All hulls.
struct HullQuestions {
  Span<const HullQuestion> hulls;
  Span<const Vec3d> points;  ///< in world coordinates

  SOFTCD_HD ProbeHull operator[](std::uint32_t i) const {
    return {{points.data() + hulls[i].first_point, hulls[i].point_count}, hulls[i].radius};
  }
};

}  // namespace softcd

#pragma once

#include "softcd/mesh/given_positions.hpp"

namespace softcd {

SOFTCD_HD inline double origin_of(double lo, double hi) {
  const auto centre = static_cast<double>(static_cast<float>(0.5 * (lo + hi)));
  const bool is_far = centre > 0 ? lo >= 0.5 * centre && hi <= 2 * centre : hi <= 0.5 * centre && lo >= 2 * centre;
  return is_far ? centre : 0.0;
}

/// Returns the point that is subtracted from all positions, in double, before they become float32. It shifts an axis
/// only where the scene is at least as far from the origin as it is wide. The difference of two numbers within a factor
/// of two of each other is exact (Sterbenz 1974). Float32 positions therefore lose nothing, and the unshifted positions
/// can be recovered.
SOFTCD_HD inline Vec3d origin_of(const Extent& scene) {
  return {origin_of(scene.lo.x, scene.hi.x), origin_of(scene.lo.y, scene.hi.y), origin_of(scene.lo.z, scene.hi.z)};
}

/// Predictions that a detection makes about positions on a device that the host has not read, apart from each body's
/// extent.
struct Predicted {
  Vec3d origin{0, 0, 0};  ///< the scene's origin, with these positions included
  Extent others;          ///< extent of all other positions that the origin depends on
  bool uses_t0 = false;   ///< the origin depends on these positions at t0, too
  bool moves = false;     ///< some vertex has different positions at t0 and t1
};

/// Returns whether vertices are within the predicted extent of their body.
SOFTCD_HD inline bool is_within(const Extent& seen, const Extent& predicted) {
  return seen.lo.x >= predicted.lo.x && seen.lo.y >= predicted.lo.y && seen.lo.z >= predicted.lo.z &&
         seen.hi.x <= predicted.hi.x && seen.hi.y <= predicted.hi.y && seen.hi.z <= predicted.hi.z;
}
SOFTCD_HD inline bool is_within(const StepSurvey& seen, const StepSurvey& predicted) {
  return seen.t0.stray_count + seen.t1.stray_count == 0 && is_within(seen.t0.extent, predicted.t0.extent) &&
         is_within(seen.t1.extent, predicted.t1.extent) && seen.squared_move <= predicted.squared_move;
}

/// Returns whether the predicted origin and motion hold for all bodies together.
SOFTCD_HD inline bool is_as_predicted(const StepSurvey& seen, const Predicted& predicted) {
  Extent extent = predicted.others;
  extent.extend(seen.t1.extent);
  if (predicted.uses_t0) extent.extend(seen.t0.extent);
  return seen.moves == predicted.moves && origin_of(extent) == predicted.origin;
}

}  // namespace softcd

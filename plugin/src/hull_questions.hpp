#pragma once

#include <vector>

#include "softcd/stages/hull_questions.hpp"

namespace softcd::detail {

/// Convex hulls, in the form that detectors take. Owned by ProbeCore.
class HullsInQuestion {
 public:
  /// Prepares hulls. Throws InvalidInput where they have 2^31 points or more in all.
  void prepare(Span<const ProbeHull> hulls);

  HullQuestions questions() const { return {hulls_, points_}; }

 private:
  std::vector<HullQuestion> hulls_;
  std::vector<Vec3d> points_;
};

}  // namespace softcd::detail

#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "scene.hpp"

namespace softcd::test {

/// What a detection of a scene must and may return: every `certain` pair, any of the `undecided`, nothing else. Both
/// are sorted. Computed serially from boxes of features and exact or long double arithmetic; no code of the detector
/// is used but its vector type.
struct Verdicts {
  std::vector<FeaturePair> certain;
  std::vector<FeaturePair> undecided;
};

struct DiscreteRules {
  PairFilter pair_filter;      ///< ids are places in the scene
  double motion_margin = 0.0;  ///< as PipelineOptions::motion_margin
  /// A distance that differs from the threshold by less than this share of the threshold decides nothing ...
  double relative_band = 1e-6;
  /// ... nor one that differs by less than this much: what rounding the coordinates may do to a distance.
  double absolute_band = 1e-12;
};

/// Pairs no further apart at t1 than the sum of their bodies' margins.
Verdicts discrete_verdicts(const Scene& scene, const DiscreteRules& rules = {});

/// Pairs that touch during the straight-line motion from t0 to t1, with margins 0: exact, nothing is undecided.
Verdicts continuous_verdicts(const Scene& scene, const PairFilter& pair_filter = {});

struct Difference {
  std::vector<FeaturePair> missed;
  std::vector<FeaturePair> extra;
  std::vector<FeaturePair> repeated;
};
Difference compare(const Verdicts& verdicts, const std::vector<FeaturePair>& reported);

/// Nothing missed, nothing extra, nothing twice.
bool agrees(const Difference& difference);
/// Counts, and the first few of each.
std::string describe(const Difference& difference);

}  // namespace softcd::test

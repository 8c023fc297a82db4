#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "scene.hpp"

namespace softcd::test {

/// The allowed results of a detection: every `certain` pair, any of the `undecided`, nothing else. Both lists are
/// sorted. They are computed serially from boxes of features and exact or long double arithmetic. Of the detector's
/// code they use only its vector type.
struct Verdicts {
  std::vector<FeaturePair> certain;
  std::vector<FeaturePair> undecided;
};

struct DiscreteRules {
  PairFilter pair_filter;      ///< ids are places in the scene
  double motion_margin = 0.0;  ///< as PipelineOptions::motion_margin
  /// A distance is undecided if it differs from the threshold by less than this share of the threshold ...
  double relative_band = 1e-6;
  /// ... or by less than this distance: the possible effect of rounding the coordinates.
  double absolute_band = 1e-12;
};

/// Returns pairs that are no further apart at t1 than the sum of their bodies' margins.
Verdicts discrete_verdicts(const Scene& scene, const DiscreteRules& rules = {});

/// Returns pairs that touch during the straight-line motion from t0 to t1, with margins 0. Exact: nothing is undecided.
Verdicts continuous_verdicts(const Scene& scene, const PairFilter& pair_filter = {});

struct Difference {
  std::vector<FeaturePair> missed;
  std::vector<FeaturePair> extra;
  std::vector<FeaturePair> repeated;
};
Difference compare(const Verdicts& verdicts, const std::vector<FeaturePair>& reported);

/// Returns whether nothing is missed, added or repeated.
bool agrees(const Difference& difference);
/// Returns the counts, and the first few of each kind.
std::string describe(const Difference& difference);

}  // namespace softcd::test

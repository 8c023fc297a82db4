#pragma once

#include <algorithm>
#include <vector>

#include "pair_selection.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/softcd.hpp"

/// What a pipeline's options mean for one detection.
namespace softcd {

/// Whether positions at t0 count only for how far they move a vertex's margin.
inline bool measures_moves(const PipelineOptions& options) {
  return options.detection == Detection::dcd && options.motion_margin > 0.0F;
}

inline MarginGrowth margin_growth(const PipelineOptions& options) {
  const bool is_slab = options.detection == Detection::dcd && options.contact_rule == ContactRule::slab;
  return {measures_moves(options) ? options.motion_margin : 0.0F, is_slab ? kSlabReach : 1.0F,
          options.accuracy == Accuracy::conservative};
}

/// Whether some vertex moves in a continuous detection.
inline bool some_body_moves(const std::vector<BodySurvey>& surveys) {
  return std::any_of(surveys.begin(), surveys.end(), [](const BodySurvey& survey) { return survey.moves; });
}

inline DetectionSettings detection_settings(const PipelineOptions& options, const PairSelection& pairs, bool moves) {
  return {options.detection,    options.accuracy,
          options.broad_phase,  options.subdivision,
          options.lambda,       pairs.pair_count > 0 ? options.motion_margin : 0.0F,
          options.contact_rule, pairs.vertex_triangle,
          pairs.edge_edge,      moves || (measures_moves(options) && pairs.pair_count > 0)};
}

}  // namespace softcd

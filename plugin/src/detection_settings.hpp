#pragma once

#include <algorithm>
#include <vector>

#include "pair_selection.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/query.hpp"

/// Derives the settings of one detection from a query's options.
namespace softcd {

/// The accuracy of a query's next detection, and why.
struct ChosenAccuracy {
  Accuracy accuracy;
  const char* reason;
};

/// Chooses the accuracy; see Accuracy::automatic.
inline ChosenAccuracy chosen_accuracy(const QueryOptions& options, const std::vector<Body>& bodies) {
  if (options.accuracy != Accuracy::automatic) return {options.accuracy, "asked for"};
  const auto some = [&](const auto& is_so) {
    return std::any_of(bodies.begin(), bodies.end(),
                       [&](const Body& body) { return !body.is_removed && body.positions.are_set() && is_so(body); });
  };
  if (some([](const Body& body) { return body.positions.are_double(); })) {
    return {Accuracy::conservative, "positions are double"};
  }
  const bool looks_within_margins = options.detection == Detection::ccd && options.margins;
  if (looks_within_margins && some([](const Body& body) { return body.settings.margin > 0.0F; })) {
    return {Accuracy::conservative, "margins apply along the path"};
  }
  return {Accuracy::precise, "positions are floats, and no margins apply along the path"};
}

/// Returns whether positions at t0 only serve to measure how far a vertex moves, for its margin.
inline bool measures_moves(const QueryOptions& options) {
  return options.detection == Detection::dcd && options.motion_margin > 0.0F;
}

/// Returns whether contacts are detected at t0, or on the path from there.
inline bool uses_t0(const QueryOptions& options) {
  return options.detection == Detection::ccd || options.step_end == StepEnd::t0;
}

inline bool uses_t1(const QueryOptions& options) {
  return options.detection == Detection::ccd || options.step_end == StepEnd::t1;
}

/// Returns whether some vertex moves in a continuous detection.
inline bool something_moves(const QueryOptions& options, const std::vector<Body>& bodies) {
  return options.detection == Detection::ccd && std::any_of(bodies.begin(), bodies.end(), [](const Body& body) {
           return body.positions.are_set() && body.positions.survey().moves;
         });
}

inline Selecting selecting(const QueryOptions& options, bool moves, std::uint64_t changed_since) {
  const bool is_slab = options.detection == Detection::dcd && options.contact_rule == ContactRule::slab;
  const bool covers_rounding = options.accuracy == Accuracy::conservative;
  const bool is_continuous = options.detection == Detection::ccd;
  Selecting result;
  result.t0 = uses_t0(options);
  result.t1 = uses_t1(options);
  result.covers_rounding_t0 = covers_rounding && (is_continuous ? moves : uses_t0(options) || measures_moves(options));
  result.covers_rounding_t1 = covers_rounding && result.t1;
  result.margins = options.margins;
  result.neighbour_filters = options.neighbour_filters;
  result.motion_margin = measures_moves(options) ? options.motion_margin : 0.0F;
  result.distance_factor = is_slab ? kSlabFactor : 1.0F;
  result.features = options.features;
  result.changed_since = changed_since;
  return result;
}

inline DetectionSettings detection_settings(const QueryOptions& options, const PairSelection& pairs, bool moves,
                                            const Partition& partition) {
  const bool has_pairs = pairs.pair_count > 0;
  return {.detection = options.detection,
          .accuracy = options.accuracy,
          .broad_phase = options.broad_phase,
          .subdivision = options.subdivision,
          .cell_size_factor = options.cell_size_factor,
          .motion_margin = has_pairs ? options.motion_margin : 0.0F,
          .contact_rule = options.contact_rule,
          .vertex_triangle = pairs.vertex_triangle,
          .edge_edge = pairs.edge_edge,
          .both_ends = moves || (measures_moves(options) && has_pairs),
          .at_t0 = options.detection == Detection::dcd && options.step_end == StepEnd::t0,
          .covers_rounding = pairs.is_rounded,
          .reuses_pairs = options.reuse_pairs,
          .contacts_stay = options.contacts_on_device,
          .partition = partition};
}

}  // namespace softcd

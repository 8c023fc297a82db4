#include "extent_prediction.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace softcd {
namespace {

double largest(const Vec3d& v) {
  return std::max({v.x, v.y, v.z});
}

/// Returns the largest outward motion of a side of the box.
double growth(const Extent& from, const Extent& to) {
  if (from.is_empty() || to.is_empty()) return 0.0;
  return std::max({0.0, largest(from.lo - to.lo), largest(to.hi - from.hi)});
}

Extent grown(Extent extent, double slack) {
  if (extent.is_empty()) return extent;
  const Vec3d by = {slack, slack, slack};
  return {extent.lo - by, extent.hi + by};
}

double diagonal(const Extent& extent) {
  return extent.is_empty() ? 0.0 : std::sqrt(squared_norm(extent.hi - extent.lo));
}

}  // namespace

void ExtentPrediction::learn(const std::vector<Body>& bodies) {
  std::vector<StepSurvey> seen(bodies.size());
  std::transform(bodies.begin(), bodies.end(), seen.begin(), [](const Body& body) { return body.positions.survey(); });
  std::swap(seen, seen_);
  if (seen.size() != seen_.size()) return;
  if (detections_to_rest_ > 0) {
    --detections_to_rest_;
    return;
  }
  std::vector<double> moves(bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!bodies[b].positions.are_on_device()) continue;
    moves[b] = std::max(growth(seen[b].t0.extent, seen_[b].t0.extent), growth(seen[b].t1.extent, seen_[b].t1.extent));
  }
  if (!is_known_ || !has_room(moves)) predict(moves);
}

/// Returns whether the prediction will probably hold for the next detection.
bool ExtentPrediction::has_room(const std::vector<double>& moves) const {
  for (std::size_t b = 0; b < moves.size(); ++b) {
    const double next = 2.0 * moves[b];
    if (!is_within(grown(seen_[b].t0.extent, next), predicted_[b].t0.extent)) return false;
    if (!is_within(grown(seen_[b].t1.extent, next), predicted_[b].t1.extent)) return false;
  }
  return true;
}

void ExtentPrediction::predict(const std::vector<double>& moves) {
  is_known_ = false;
  predicted_ = seen_;
  for (std::size_t b = 0; b < moves.size(); ++b) {
    StepSurvey& body = predicted_[b];
    const double slack = std::min(kDetections * moves[b], kMostSlack * diagonal(body.t1.extent));
    if (slack < kFewestDetections * moves[b]) return;
    body.t0.extent = grown(body.t0.extent, slack);
    body.t1.extent = grown(body.t1.extent, slack);
    body.squared_move *= 4.0;
    // The flags belong to the doubles read before. Predictions are only used for floats where rounding matters, and
    // floats are not rounded.
    body.t0.is_rounded = body.t1.is_rounded = false;
  }
  is_known_ = true;
  ++number_;
}

void ExtentPrediction::fail() {
  is_known_ = false;
  if (detections_ < kFewestDetections) detections_to_rest_ = kRest;
  detections_ = 0;
}

void ExtentPrediction::forget() {
  is_known_ = false;
  seen_.clear();
}

}  // namespace softcd

#include "foresight.hpp"

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

void Foresight::learn(const std::vector<Body>& bodies) {
  std::vector<StepSurvey> seen(bodies.size());
  std::transform(bodies.begin(), bodies.end(), seen.begin(), [](const Body& body) { return body.positions.survey(); });
  std::swap(seen, seen_);
  if (seen.size() != seen_.size()) return;
  if (looks_to_rest_ > 0) {
    --looks_to_rest_;
    return;
  }
  std::vector<double> moves(bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!bodies[b].positions.are_on_device()) continue;
    moves[b] = std::max(growth(seen[b].t0.extent, seen_[b].t0.extent), growth(seen[b].t1.extent, seen_[b].t1.extent));
  }
  if (!is_known_ || !has_room(moves)) foresee(moves);
}

/// Returns whether the prediction will probably hold for the next detection.
bool Foresight::has_room(const std::vector<double>& moves) const {
  for (std::size_t b = 0; b < moves.size(); ++b) {
    const double next = 2.0 * moves[b];
    if (!is_within(grown(seen_[b].t0.extent, next), foreseen_[b].t0.extent)) return false;
    if (!is_within(grown(seen_[b].t1.extent, next), foreseen_[b].t1.extent)) return false;
  }
  return true;
}

void Foresight::foresee(const std::vector<double>& moves) {
  is_known_ = false;
  foreseen_ = seen_;
  for (std::size_t b = 0; b < moves.size(); ++b) {
    StepSurvey& body = foreseen_[b];
    const double slack = std::min(kLooks * moves[b], kMostSlack * diagonal(body.t1.extent));
    if (slack < kFewestLooks * moves[b]) return;
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

void Foresight::fail() {
  is_known_ = false;
  if (looks_ < kFewestLooks) looks_to_rest_ = kRest;
  looks_ = 0;
}

void Foresight::forget() {
  is_known_ = false;
  seen_.clear();
}

}  // namespace softcd

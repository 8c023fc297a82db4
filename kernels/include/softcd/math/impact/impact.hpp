#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/impact/advancement.hpp"
#include "softcd/math/impact/coplanar.hpp"
#include "softcd/math/impact/motion.hpp"
#include "softcd/math/impact/normal.hpp"
#include "softcd/math/impact/query.hpp"
#include "softcd/math/scalar.hpp"

/// Time of impact of a vertex and a triangle, or of two edges, whose vertices move on straight lines from t = 0 to t =
/// 1. Four moving points are coplanar at the roots of a cubic (Provot, Collision and self-collision handling in cloth
/// model dedicated to design garments, 1997). Features can touch only at these times.
///
/// **Reported hits.** Let reach = margin + tolerance. A hit is reported at the earliest of these times at which the
/// distance is at most reach:
/// - t = 0;
/// - each t in [0, 1] at which the points are coplanar, or cannot be told from coplanar within the rounding bound of
///   the cubic;
/// - t = 1.
///
/// The tolerance is 32 epsilon (A + B + C), where A, B, C bound the components of v - f0, f1 - f0, f2 - f0 (e0 - g0, e1
/// - e0, g1 - g0) at both times. `time` is not later than the first contact at distance 0.
///
/// **Guarantee.** All features that touch, in exact arithmetic on the given coordinates, are hits, with any margin >=
/// 0. Roundings are bounded (see `make_query` in query.hpp) and counted against the result "separated". A false hit has
/// a distance of at most reach at `time`, with one exception.
///
/// Within a coplanar stretch (a planar motion, a degenerate triangle, the neighbourhood of a root) the distance is
/// followed by advancement. It may not decide within kMaxAdvances steps, or its steps may become smaller than t
/// resolves. The result is then a hit with the distance at that time.
///
/// **Margins.** `first_coplanar_impact` compares distances with the margin at these times only. It misses features that
/// come within a positive margin and leave it again without being coplanar, for example at the edge of a triangle. It
/// reports a contact when the features are coplanar, not when they come within the margin.
///
/// `first_approach` follows the distance over the whole step instead. All features that come within the margin are
/// hits, and `time` is not later than that. At `time` the distance is at most reach, with twice the tolerance and a
/// millionth of the margin. Where kMostApproachSteps steps do not decide, it may be somewhat more.
/// docs/measured/accuracy.md has the proof.
///
/// In float the same bounds hold for float coordinates; tolerance and coplanar stretches are 2^29 times as wide.
/// Coordinates' differences must be finite.
namespace softcd {

enum class ImpactState {
  separated,
  hit,
  unsettled,  ///< counts as a hit; only from first_approach
};

template <class T>
struct Impact {
  ImpactState state;
  T time;          ///< 1 when separated
  T weights[4];    ///< vertex-triangle {1, w0, w1, w2}, edge-edge {u0, u1, w0, w1}
  Vec3<T> normal;  ///< unit, from side b to side a; when the points touch, towards where a came from
  T distance;      ///< at `time`
};

namespace detail {

template <ContactKind kKind, class T>
SOFTCD_HD Impact<T> to_impact(const Motion<T>& motion, const Touch<T>& touch, T side, T scale) {
  const T distance = square_root(touch.nearest.squared_distance);
  Impact<T> impact;
  impact.state = touch.is_settled ? ImpactState::hit : ImpactState::unsettled;
  impact.time = touch.time;
  write_weights<kKind>(touch.nearest.x, touch.nearest.y, impact.weights);
  const bool is_apart = distance > T(4) * motion.tolerance;
  impact.normal = unit_vector(is_apart ? touch.nearest.offset : normal_of_touch(motion, touch, side));
  impact.distance = distance / scale;
  return impact;
}

template <class T>
SOFTCD_HD Impact<T> separated() {
  const Vec3<T> zero{T(0), T(0), T(0)};
  return {ImpactState::separated, T(1), {T(0), T(0), T(0), T(0)}, zero, T(0)};
}

template <ContactKind kKind, class T>
SOFTCD_HD Impact<T> coplanar_impact(const Motion<T>& input) {
  const Query<T> query = make_query(input);
  const Motion<T>& motion = query.motion;
  Touch<T> touch = touch_nowhere<T>();
  if (query.may_reach_t0) {
    touch = touch_at<kKind>(motion, motion.t0, T(0));
  }
  if (!touch.is_hit && !query.is_never_coplanar) {
    const T unit = query.volume > T(0) ? T(1) / query.volume : T(0);
    const Cubic<T> normalized{unit * query.cubic.b0, unit * query.cubic.b1, unit * query.cubic.b2,
                              unit * query.cubic.b3};
    touch = first_coplanar_touch<kKind>(motion, normalized, kCubicError<T>);
  }
  if (!touch.is_hit && query.may_reach_t1) {
    touch = touch_at<kKind>(motion, motion.t1, T(1));
  }
  return touch.is_hit ? to_impact<kKind>(motion, touch, query.side, query.scale) : separated<T>();
}

template <ContactKind kKind, class T>
SOFTCD_HD Motion<T> motion_of(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
  return {relative_pair<kKind>(t0), relative_pair<kKind>(t1), margin, T(0)};
}

}  // namespace detail

/// Returns the tolerance of distances at one time: 32 epsilon (A + B + C), as above.
template <ContactKind kKind, class T>
SOFTCD_HD T distance_tolerance(const Vec3<T> (&x)[4]) {
  const detail::RelativePair<T> pair = detail::relative_pair<kKind>(x);
  return detail::kDistanceError<T> * (max_norm(pair.a) + max_norm(pair.b) + max_norm(pair.c));
}

/// Returns the hit at the earliest of the times above. The four points at each end are v (side a), f0, f1, f2 (side b),
/// or e0, e1 (side a), g0, g1 (side b).
template <ContactKind kKind, class T>
SOFTCD_HD Impact<T> first_coplanar_impact(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
  Impact<T> impact = detail::coplanar_impact<kKind>(detail::motion_of<kKind>(t0, t1, margin));
  if (impact.state == ImpactState::unsettled) impact.state = ImpactState::hit;
  return impact;
}

/// Runs first_approach with a margin in steps: call begin() and then advance() until one of them returns true.
template <ContactKind kKind, class T>
class Approach {
 public:
  /// Starts the search. Returns true when the features are certainly apart.
  SOFTCD_HD bool begin(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
    detail::Query<T> query = detail::make_query(detail::motion_of<kKind>(t0, t1, margin));
    query.motion.tolerance = T(2) * query.motion.tolerance + detail::kMarginTolerance<T> * query.motion.margin;
    search_ = detail::ApproachSearch<kKind, T>(query.motion);
    side_ = query.side;
    scale_ = query.scale;
    return query.is_apart_throughout;
  }
  SOFTCD_HD bool advance() { return search_.advance(); }
  SOFTCD_HD bool is_hit() const { return search_.touch().is_hit; }
  /// Returns the hit.
  SOFTCD_HD Impact<T> impact() const {
    return detail::to_impact<kKind>(search_.motion(), search_.touch(), side_, scale_);
  }

 private:
  detail::ApproachSearch<kKind, T> search_;
  T side_, scale_;
};

/// Returns the hit at the time when the features first come within the margin. Without a margin that is the first
/// touch, at a coplanar time. The points are ordered as above.
template <ContactKind kKind, class T>
SOFTCD_HD Impact<T> first_approach(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
  if (!(margin > T(0))) return detail::coplanar_impact<kKind>(detail::motion_of<kKind>(t0, t1, margin));
  Approach<kKind, T> approach;
  bool is_done = approach.begin(t0, t1, margin);
  while (!is_done) is_done = approach.advance();
  return approach.is_hit() ? approach.impact() : detail::separated<T>();
}

/// Returns true only where first_coplanar_impact of the same features would be `separated`. A cheap test that
/// recognises most such cases.
template <ContactKind kKind, class T>
SOFTCD_HD bool certainly_apart_when_coplanar(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
  return detail::make_query(detail::motion_of<kKind>(t0, t1, margin)).is_apart_when_coplanar();
}

/// Returns true only where first_approach of the same features would be `separated`. A cheap test that recognises most
/// such cases.
template <ContactKind kKind, class T>
SOFTCD_HD bool certainly_apart_throughout(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
  return detail::make_query(detail::motion_of<kKind>(t0, t1, margin)).is_apart_throughout;
}

/// Returns true only where the features are further apart than `margin` at one time, because their planes (or the
/// parallel planes through their lines) are. A cheap test.
template <ContactKind kKind, class T>
SOFTCD_HD bool certainly_apart(const Vec3<T> (&x)[4], T margin) {
  const detail::RelativePair<T> pair = detail::relative_pair<kKind>(x);
  const T scale = safe_scale(detail::extent(pair));
  return detail::is_certainly_apart(scale == T(1) ? pair : detail::scaled(scale, pair), scale * margin);
}

}  // namespace softcd

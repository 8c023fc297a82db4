#pragma once

#include <type_traits>

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/cubic.hpp"
#include "softcd/math/scalar.hpp"

/// Time of impact of a vertex and a triangle, or of two edges, whose vertices move on straight lines from t = 0 to
/// t = 1. Four moving points are coplanar at the roots of a cubic (Provot, Collision and self-collision handling in
/// cloth model dedicated to design garments, 1997); features can touch only then.
///
/// **What is found.** With reach = margin + tolerance, a hit is reported at the earliest of
///   - t = 0, when the distance there is at most reach,
///   - each t in [0, 1] at which the points are coplanar, or cannot be told from coplanar by the rounding bound of
///     the cubic, when the distance there is at most reach,
///   - t = 1, when the distance there is at most reach.
/// The distance's tolerance is 32 epsilon (A + B + C), where A, B, C bound the components of v - f0, f1 - f0, f2 - f0
/// (e0 - g0, e1 - e0, g1 - g0) at both times. `time` is not later than the first contact at distance 0.
///
/// **Guarantee.** Whatever touches for the given coordinates in exact arithmetic is hit, with any margin >= 0:
/// roundings are bounded (see `make_query` below) and counted against the answer "separated". A hit that is none has a
/// distance of at most reach at `time`, with one exception, also on the side of "hit": within a coplanar stretch (a
/// planar motion, a degenerate triangle, the neighbourhood of a root) the distance is followed by advancement, and when
/// kMaxAdvances steps do not settle the question, or steps become smaller than t resolves, the answer is a hit with the
/// distance at that time.
///
/// **Margins.** `first_coplanar_impact` looks for distances within the margin at these times only: it misses features
/// that come within a positive margin and leave it again without being coplanar, at the edge of a triangle, say, and
/// reports the contact when they are coplanar, not when they come within the margin. `first_approach` follows the
/// distance over the whole step instead: whatever comes within the margin is hit, `time` is not later than that,
/// and at `time` the distance is at most reach, with twice the tolerance and a millionth of the margin, or, where
/// kMostApproachSteps do not settle the question, somewhat more. docs/accuracy.md has the proof.
///
/// In float the same bounds hold for float coordinates; tolerance and coplanar stretches are 2^29 times as wide.
/// Coordinates' differences must be finite.
namespace softcd {

enum class ImpactState {
  separated,
  hit,
  unsettled,  ///< counts as a hit; of first_approach only
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

/// Of 170,000 hits on hard float queries (near grazing, degenerate, needles) 60 need more steps, or smaller ones than t
/// resolves.
constexpr int kMaxAdvances = 32;
/// For motions followed from beginning to end.
constexpr int kMostApproachSteps = 64;
constexpr int kStepsInTwoDirections = 8;
/// Hits may be that share of the margin farther apart than it: margins are sums of floats, and steps converge to this
/// in 5 instead of 7.
template <class T>
constexpr T kMarginTolerance = T(0x1p-20);

/// Everything about a query that its stages share.
template <class T>
struct Motion {
  RelativePair<T> t0, t1;
  T margin;
  T tolerance;

  SOFTCD_HD RelativePair<T> at(T t) const {
    return {interpolate(t0.a, t1.a, t), interpolate(t0.b, t1.b, t), interpolate(t0.c, t1.c, t)};
  }
  SOFTCD_HD T reach() const { return margin + tolerance; }
};

/// A direction n(t) that moves linearly from `begin` to `end`.
template <class T>
struct MovingDirection {
  Vec3<T> begin, end;
};

/// An edge of the features: along_b b + along_c c, or none when both are 0.
template <class T>
struct EdgeChoice {
  T along_b, along_c;

  SOFTCD_HD Vec3<T> of(const RelativePair<T>& pair) const { return along_b * pair.b + along_c * pair.c; }
};

/// The edge that holds one of the nearest points in its interior while the other one is a vertex.
template <ContactKind kKind, class T>
SOFTCD_HD EdgeChoice<T> supporting_edge(T x, T y) {
  if constexpr (kKind == ContactKind::vertex_triangle) {
    const T rest = (T(1) - x) - y;
    if (x == T(1) || y == T(1) || rest == T(1)) {
      return {T(0), T(0)};
    }
    return y == T(0) ? EdgeChoice<T>{T(1), T(0)} : (x == T(0) ? EdgeChoice<T>{T(0), T(1)} : EdgeChoice<T>{T(-1), T(1)});
  } else {
    const bool is_x_inside = x < T(0) && x > T(-1);
    const bool is_y_inside = y > T(0) && y < T(1);
    return {is_x_inside && !is_y_inside ? T(1) : T(0), is_y_inside && !is_x_inside ? T(1) : T(0)};
  }
}

template <ContactKind kKind, class T>
SOFTCD_HD EdgeChoice<T> longest_edge(const RelativePair<T>& pair) {
  const T b = squared_norm(pair.b);
  const T c = squared_norm(pair.c);
  if constexpr (kKind == ContactKind::vertex_triangle) {
    if (squared_norm(pair.c - pair.b) > larger(b, c)) {
      return {T(-1), T(1)};
    }
  }
  return b > c ? EdgeChoice<T>{T(1), T(0)} : EdgeChoice<T>{T(0), T(1)};
}

/// What of a is perpendicular to the edge; a itself when the edge has no length.
template <class T>
SOFTCD_HD Vec3<T> perpendicular_part(Vec3<T> a, Vec3<T> edge) {
  const T square = squared_norm(edge);
  return square > T(0) ? (T(1) / square) * cross(cross(edge, a), edge) : a;
}

/// The plane's normal, on a's side, now and at the end. Close to the plane the offset's own direction is all
/// rounding, and this one is not. It is made perpendicular to the longest edge, over which an error of a needle's
/// normal would count most. Zero for a plane that is none.
template <ContactKind kKind, class T>
SOFTCD_HD MovingDirection<T> plane_direction(const RelativePair<T>& now, const RelativePair<T>& end,
                                             const Nearest<T>& nearest) {
  const Vec3<T> plane = cross(now.b, now.c);
  const T length = norm(plane);
  const T scale = length > T(0) ? (dot(plane, nearest.offset) < T(0) ? T(-1) : T(1)) / length : T(0);
  const EdgeChoice<T> longest = longest_edge<kKind>(now);
  return {perpendicular_part(scale * plane, longest.of(now)),
          perpendicular_part(scale * cross(end.b, end.c), longest.of(end))};
}

/// The plane's normal, on a's side, with its own velocity: perpendicular to both edges not only now but, to first
/// order, right after. Steps along it converge quadratically where two edges meet.
template <class T>
SOFTCD_HD MovingDirection<T> turning_plane_direction(const RelativePair<T>& now, const RelativePair<T>& end,
                                                     const Nearest<T>& nearest) {
  const Vec3<T> plane = cross(now.b, now.c);
  const T length = norm(plane);
  const T scale = length > T(0) ? (dot(plane, nearest.offset) < T(0) ? T(-1) : T(1)) / length : T(0);
  const Vec3<T> change = cross(end.b - now.b, now.c) + cross(now.b, end.c - now.c);
  return {scale * plane, scale * (plane + change)};
}

/// The offset's direction; with a supporting edge, what stays perpendicular to it as it turns.
template <ContactKind kKind, class T>
SOFTCD_HD MovingDirection<T> offset_direction(const RelativePair<T>& now, const RelativePair<T>& end,
                                              const Nearest<T>& nearest) {
  const Vec3<T> unit = (T(1) / norm(nearest.offset)) * nearest.offset;
  const EdgeChoice<T> support = supporting_edge<kKind>(nearest.x, nearest.y);
  const Vec3<T> edge = support.of(now);
  const T square = squared_norm(edge);
  if (!(square > T(0))) {
    return {unit, unit};
  }
  const Vec3<T> axis = (T(1) / square) * cross(edge, unit);
  return {cross(axis, edge), cross(axis, support.of(end))};
}

/// Fraction of [begin, end] during which n . r stays above `gap` |n|. |n| is convex in time, so the chord of its
/// values is above it and the difference to it is a quadratic.
template <class T>
SOFTCD_HD T clear_fraction(const MovingDirection<T>& n, T gap, T end_gap, Vec3<T> r_begin, Vec3<T> r_end) {
  const T g0 = dot(n.begin, r_begin) - gap;
  const T g1 = T(0.5) * ((dot(n.begin, r_end) + dot(n.end, r_begin)) - (gap + end_gap));
  const T g2 = dot(n.end, r_end) - end_gap;
  return g0 > T(0) ? first_root(g0, g1, g2) : T(0);
}

/// Fraction of the time from `now` to `end` during which the features stay farther apart than `margin` plus half
/// the tolerance: no pair of their vertices comes closer along the direction n, hence no pair of points.
template <ContactKind kKind, class T>
SOFTCD_HD T clear_fraction(const Motion<T>& motion, const RelativePair<T>& now, const RelativePair<T>& end,
                           const MovingDirection<T>& n) {
  const T distance = motion.margin + T(0.5) * motion.tolerance;
  const T gap = distance * norm(n.begin);
  const T end_gap = distance * norm(n.end);
  T fraction = clear_fraction(n, gap, end_gap, now.a, end.a);
  fraction = smaller(fraction, clear_fraction(n, gap, end_gap, now.a - now.c, end.a - end.c));
  if constexpr (kKind == ContactKind::vertex_triangle) {
    fraction = smaller(fraction, clear_fraction(n, gap, end_gap, now.a - now.b, end.a - end.b));
  } else {
    const Vec3<T> r_begin = now.a + now.b;
    const Vec3<T> r_end = end.a + end.b;
    fraction = smaller(fraction, clear_fraction(n, gap, end_gap, r_begin, r_end));
    fraction = smaller(fraction, clear_fraction(n, gap, end_gap, r_begin - now.c, r_end - end.c));
  }
  return fraction > T(0) ? fraction : T(0);
}

/// The longest such step. Every direction is valid, however it was come by: a poor one makes a short step.
template <ContactKind kKind, class T>
SOFTCD_HD T advance(const Motion<T>& motion, const RelativePair<T>& now, const RelativePair<T>& end,
                    const Nearest<T>& nearest) {
  const T fraction = clear_fraction<kKind>(motion, now, end, offset_direction<kKind>(now, end, nearest));
  return fraction < T(1)
             ? larger(clear_fraction<kKind>(motion, now, end, plane_direction<kKind>(now, end, nearest)), fraction)
             : fraction;
}

/// The same for motions that are followed from beginning to end. The third direction lengthens few steps, but those of
/// motions that take many.
template <ContactKind kKind, class T>
SOFTCD_HD T advance_far(const Motion<T>& motion, const RelativePair<T>& now, const RelativePair<T>& end,
                        const Nearest<T>& nearest, int step) {
  const T fraction = step < kStepsInTwoDirections
                         ? clear_fraction<kKind>(motion, now, end, offset_direction<kKind>(now, end, nearest))
                         : advance<kKind>(motion, now, end, nearest);
  return fraction < T(1)
             ? larger(clear_fraction<kKind>(motion, now, end, turning_plane_direction(now, end, nearest)), fraction)
             : fraction;
}

/// Where the features touch, and how they lay before that.
template <class T>
struct Touch {
  bool is_hit;
  bool is_settled;
  T time;
  Nearest<T> nearest;
  Vec3<T> approach;  ///< the offset at the last step where they were clearly apart; zero when they never were
};

template <class T>
SOFTCD_HD Touch<T> touch_nowhere() {
  const Vec3<T> zero{T(0), T(0), T(0)};
  return {false, true, T(1), {T(0), T(0), zero, T(0)}, zero};
}

/// First time in [begin, end] at which the features are within reach, by steps that leave no such time behind.
template <ContactKind kKind, bool kWholeWay, class T>
SOFTCD_HD Touch<T> first_touch(const Motion<T>& motion, T begin, T end) {
  Touch<T> touch = touch_nowhere<T>();
  touch.is_settled = false;
  T t = begin;
  const RelativePair<T> last = motion.at(end);
  for (int step = 0; step < (kWholeWay ? kMostApproachSteps : kMaxAdvances); ++step) {
    const RelativePair<T> now = motion.at(t);
    touch.time = t;
    touch.nearest = nearest<kKind>(now);
    const T distance = square_root(touch.nearest.squared_distance);
    if (distance <= motion.reach()) {
      touch.is_settled = true;
      break;
    }
    if (distance > T(4) * motion.tolerance) {
      touch.approach = touch.nearest.offset;
    }
    const T fraction = kWholeWay ? advance_far<kKind>(motion, now, last, touch.nearest, step)
                                 : advance<kKind>(motion, now, last, touch.nearest);
    if (fraction >= T(1)) {
      return touch;
    }
    const T next = smaller(t + fraction * (end - t), end);
    if (!(next > t)) {
      break;
    }
    t = next;
  }
  touch.is_hit = true;
  return touch;
}

template <ContactKind kKind, class T>
SOFTCD_HD Touch<T> touch_at(const Motion<T>& motion, const RelativePair<T>& pair, T t) {
  Touch<T> touch = touch_nowhere<T>();
  touch.time = t;
  touch.nearest = nearest<kKind>(pair);
  touch.is_hit = square_root(touch.nearest.squared_distance) <= motion.reach();
  return touch;
}

/// First touch while the points are coplanar or nearly so: |cubic| <= bound. A tangential root has no change of sign
/// and is found all the same, at the end of two monotone intervals where the value is within the bound.
template <ContactKind kKind, class T>
SOFTCD_HD Touch<T> first_coplanar_touch(const Motion<T>& motion, const Cubic<T>& cubic, T bound) {
  const Splits<T> splits = monotone_splits(cubic);
  T begin = T(0);
  T end = splits.first;
  for (int piece = 0; piece < 3; ++piece) {
    const T at_begin = cubic(begin);
    const T at_end = cubic(end);
    const bool is_clear = (at_begin > bound && at_end > bound) || (at_begin < -bound && at_end < -bound);
    if (begin < end && !is_clear) {
      const T first = last_clear(cubic, bound, begin, end, secant_root(begin, end, at_begin, at_end));
      // The values go from bound to -bound at much the same slope.
      const T last = last_clear(cubic, bound, end, begin, first + T(2.25) * bound / magnitude(cubic.slope(first)));
      const Touch<T> touch = first_touch<kKind, false>(motion, first, last);
      if (touch.is_hit) {
        return touch;
      }
    }
    begin = end;
    end = piece == 0 ? splits.second : T(1);
  }
  return touch_nowhere<T>();
}

/// Some direction perpendicular to a, or any when a is zero.
template <class T>
SOFTCD_HD Vec3<T> any_perpendicular(Vec3<T> a) {
  const Vec3<T> axis = magnitude(a.x) <= magnitude(a.y) ? Vec3<T>{T(1), T(0), T(0)} : Vec3<T>{T(0), T(1), T(0)};
  return max_norm(a) > T(0) ? cross(a, axis) : axis;
}

/// The direction of the normal of features that touch. In order: the direction in which they were apart before; the
/// plane's normal towards a's side at t0; the plane's normal against the relative motion; against the relative
/// motion; any. `side` tells where a was at t0 relative to b x c by its sign, 0 when that cannot be told.
template <class T>
SOFTCD_HD Vec3<T> normal_of_touch(const Motion<T>& motion, const Touch<T>& touch, T side) {
  if (max_norm(touch.approach) > T(0)) {
    return touch.approach;
  }
  const RelativePair<T> now = motion.at(touch.time);
  const Vec3<T> plane = cross(now.b, now.c);
  const T length = norm(plane);
  const bool is_plane = length > T(64) * epsilon<T>() * (norm(now.b) * norm(now.c));
  const Vec3<T> velocity = (motion.t1.a - motion.t0.a) - touch.nearest.x * (motion.t1.b - motion.t0.b) -
                           touch.nearest.y * (motion.t1.c - motion.t0.c);
  const T speed = norm(velocity);
  const T across = dot(plane, velocity);
  if (is_plane && side != T(0)) {
    return side < T(0) ? -plane : plane;
  }
  if (is_plane && magnitude(across) > T(64) * epsilon<T>() * (length * speed)) {
    return across > T(0) ? -plane : plane;
  }
  if (speed > motion.tolerance) {
    return -velocity;
  }
  return is_plane ? plane : any_perpendicular(max_norm(now.b) > T(0) ? now.b : now.c);
}

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

/// Whether the distance of the features may be within reach, given that of the planes or lines that they lie in:
/// height / |plane|. True when that cannot be told.
template <class T>
SOFTCD_HD bool may_reach(T height, Vec3<T> plane, T reach) {
  return !(height > T(0) && height * height > reach * reach * squared_norm(plane));
}

/// What A B C and B C must be at least: squares of what else is compared then lose less to underflow than is kept for
/// roundings. Bounds A, B, C and volumes are those of make_query.
template <class T>
SOFTCD_HD constexpr T smallest_product() {
  return std::is_same_v<T, float> ? T(0x1p-50) : T(0x1p-480);
}

/// Bounds of roundings: see make_query.
template <class T>
SOFTCD_HD bool lies_apart(const RelativePair<T>& pair, T margin) {
  const T size_a = max_norm(pair.a);
  const T size_b = max_norm(pair.b);
  const T size_c = max_norm(pair.c);
  const T volume = size_a * size_b * size_c;
  const Vec3<T> plane = cross(pair.b, pair.c);
  const T height = magnitude(dot(pair.a, plane)) - T(40) * epsilon<T>() * volume;
  const T reach = margin + T(32) * epsilon<T>() * (size_a + size_b + size_c);
  const bool has_volume = smaller(volume, size_b * size_c) >= smallest_product<T>();
  return has_volume && !may_reach(height, plane, reach);
}

/// A motion with the cubic of its coplanar times, and what is certain about it.
template <class T>
struct Query {
  Motion<T> motion;
  T scale;
  Cubic<T> cubic;
  T volume;  ///< 0 when it is too small to tell anything
  T side;    ///< sign: where a is at t0 relative to b x c; 0 when that cannot be told
  bool is_never_coplanar;
  bool may_reach_t0, may_reach_t1;
  bool stays_beyond_reach;  ///< the planes, or the parallel planes through the lines, that the features lie in

  SOFTCD_HD bool keeps_apart() const { return is_never_coplanar && !may_reach_t0 && !may_reach_t1; }
};

/// With `volume` = A B C, no product of three components exceeds it, and the six terms of a determinant are at most
/// 6 volume. Coefficients (b1 and b2 taken by thirds) are off by at most 12 roundings of that, 36 epsilon volume. A
/// value of the cubic adds 10 roundings, and the splits shift it by less than 25: in all below 192 epsilon volume.
/// Products so small that underflow might add to this count as 0: coplanar all along.
template <class T>
SOFTCD_HD Query<T> make_query(Motion<T> motion) {
  T size_a = larger(max_norm(motion.t0.a), max_norm(motion.t1.a));
  T size_b = larger(max_norm(motion.t0.b), max_norm(motion.t1.b));
  T size_c = larger(max_norm(motion.t0.c), max_norm(motion.t1.c));
  const T scale = safe_scale(larger(larger(size_a, size_b), size_c));
  if (scale != T(1)) {
    motion = {scaled(scale, motion.t0), scaled(scale, motion.t1), scale * motion.margin, T(0)};
    size_a *= scale;
    size_b *= scale;
    size_c *= scale;
  }
  motion.tolerance = T(32) * epsilon<T>() * (size_a + size_b + size_c);
  const T volume = size_a * size_b * size_c;
  const bool has_volume = smaller(volume, size_b * size_c) >= smallest_product<T>();
  const T error = T(40) * epsilon<T>() * volume;

  const Vec3<T> plane_t0 = cross(motion.t0.b, motion.t0.c);
  const Vec3<T> plane_t1 = cross(motion.t1.b, motion.t1.c);
  const Vec3<T> plane_mixed = cross(motion.t0.b, motion.t1.c) + cross(motion.t1.b, motion.t0.c);
  const Cubic<T> cubic{dot(motion.t0.a, plane_t0), dot(motion.t1.a, plane_t0) + dot(motion.t0.a, plane_mixed),
                       dot(motion.t1.a, plane_mixed) + dot(motion.t0.a, plane_t1), dot(motion.t1.a, plane_t1)};

  const T lowest = smaller(smaller(cubic.b0, cubic.b3), T(1) / T(3) * smaller(cubic.b1, cubic.b2));
  const T highest = larger(larger(cubic.b0, cubic.b3), T(1) / T(3) * larger(cubic.b1, cubic.b2));
  // b x c is a quadratic with the Bernstein coefficients plane_t0, plane_mixed / 2, plane_t1.
  const T longest = larger(larger(norm(plane_t0), T(0.5) * norm(plane_mixed)), norm(plane_t1));
  // The lengths' own roundings count where the reach is below |a|, else the planes are within reach anyhow.
  const T threshold = T(64) * epsilon<T>() * volume + (T(1) + T(32) * epsilon<T>()) * (motion.reach() * longest);
  return {motion,
          scale,
          cubic,
          has_volume ? volume : T(0),
          has_volume && magnitude(cubic.b0) > error ? cubic.b0 : T(0),
          has_volume && (lowest > error || highest < -error),
          !has_volume || may_reach(magnitude(cubic.b0) - error, plane_t0, motion.reach()),
          !has_volume || may_reach(magnitude(cubic.b3) - error, plane_t1, motion.reach()),
          has_volume && (lowest > threshold || highest < -threshold)};
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
    touch = first_coplanar_touch<kKind>(motion, normalized, T(192) * epsilon<T>());
  }
  if (!touch.is_hit && query.may_reach_t1) {
    touch = touch_at<kKind>(motion, motion.t1, T(1));
  }
  return touch.is_hit ? to_impact<kKind>(motion, touch, query.side, query.scale) : separated<T>();
}

template <ContactKind kKind, class T>
SOFTCD_HD Impact<T> approach(const Motion<T>& input) {
  Query<T> query = make_query(input);
  if (query.stays_beyond_reach) {
    return separated<T>();
  }
  query.motion.tolerance = T(2) * query.motion.tolerance + kMarginTolerance<T> * query.motion.margin;
  const Touch<T> touch = first_touch<kKind, true>(query.motion, T(0), T(1));
  return touch.is_hit ? to_impact<kKind>(query.motion, touch, query.side, query.scale) : separated<T>();
}

template <ContactKind kKind, class T>
SOFTCD_HD Motion<T> motion_of(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
  return {relative_pair<kKind>(t0), relative_pair<kKind>(t1), margin, T(0)};
}

}  // namespace detail

/// The tolerance of distances at one time: 32 epsilon (A + B + C), as above.
template <ContactKind kKind, class T>
SOFTCD_HD T distance_tolerance(const Vec3<T> (&x)[4]) {
  const detail::RelativePair<T> pair = detail::relative_pair<kKind>(x);
  return T(32) * epsilon<T>() * (max_norm(pair.a) + max_norm(pair.b) + max_norm(pair.c));
}

/// The hit at the earliest of the times above. Corners at both ends: v (side a), f0, f1, f2 (side b), or e0, e1
/// (side a), g0, g1 (side b).
template <ContactKind kKind, class T>
SOFTCD_HD Impact<T> first_coplanar_impact(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
  Impact<T> impact = detail::coplanar_impact<kKind>(detail::motion_of<kKind>(t0, t1, margin));
  if (impact.state == ImpactState::unsettled) impact.state = ImpactState::hit;
  return impact;
}

/// When the features first come within the margin; without one, when they first touch, which they do when coplanar.
/// Corners as above.
template <ContactKind kKind, class T>
SOFTCD_HD Impact<T> first_approach(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
  const detail::Motion<T> motion = detail::motion_of<kKind>(t0, t1, margin);
  return margin > T(0) ? detail::approach<kKind>(motion) : detail::coplanar_impact<kKind>(motion);
}

/// Cheap and certain: true only where first_coplanar_impact of the same features would be `separated`, and in most such
/// cases.
template <ContactKind kKind, class T>
SOFTCD_HD bool keep_apart(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
  return detail::make_query(detail::motion_of<kKind>(t0, t1, margin)).keeps_apart();
}

/// The same for first_approach.
template <ContactKind kKind, class T>
SOFTCD_HD bool stay_beyond_reach(const Vec3<T> (&t0)[4], const Vec3<T> (&t1)[4], T margin) {
  return detail::make_query(detail::motion_of<kKind>(t0, t1, margin)).stays_beyond_reach;
}

/// The same at one time: true only where the features are further apart than `margin`, because the planes (the parallel
/// planes through the two lines) that they lie in are.
template <ContactKind kKind, class T>
SOFTCD_HD bool lie_apart(const Vec3<T> (&x)[4], T margin) {
  const detail::RelativePair<T> pair = detail::relative_pair<kKind>(x);
  const T scale = safe_scale(detail::extent(pair));
  return detail::lies_apart(scale == T(1) ? pair : detail::scaled(scale, pair), scale * margin);
}

}  // namespace softcd

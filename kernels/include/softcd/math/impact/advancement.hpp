#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/math/cubic.hpp"
#include "softcd/math/impact/motion.hpp"

namespace softcd::detail {

/// Most steps through a coplanar stretch. Of 170,000 hits on hard float queries (near grazing, degenerate, needles) 60
/// need more steps, or smaller ones than t resolves.
constexpr int kMaxAdvances = 32;
/// Most steps through a motion that is followed from beginning to end.
constexpr int kMostApproachSteps = 64;
/// The number of first steps that try two of the three directions.
constexpr int kStepsInTwoDirections = 8;
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

/// Returns the edge that has one of the nearest points in its interior while the other nearest point is a vertex.
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

/// Returns the part of a that is perpendicular to the edge; a itself when the edge has no length.
template <class T>
SOFTCD_HD Vec3<T> perpendicular_part(Vec3<T> a, Vec3<T> edge) {
  const T square = squared_norm(edge);
  return square > T(0) ? (T(1) / square) * cross(cross(edge, a), edge) : a;
}

/// Returns the plane's normal, on a's side, now and at the end. Close to the plane the offset's own direction is mere
/// rounding; the normal is not. It is made perpendicular to the longest edge, over which an error of a needle's normal
/// would count most. Zero where there is no plane.
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

/// Returns the plane's normal, on a's side, with its own velocity: perpendicular to both edges now and, to first order,
/// right afterwards. Steps along it converge quadratically where two edges meet.
template <class T>
SOFTCD_HD MovingDirection<T> turning_plane_direction(const RelativePair<T>& now, const RelativePair<T>& end,
                                                     const Nearest<T>& nearest) {
  const Vec3<T> plane = cross(now.b, now.c);
  const T length = norm(plane);
  const T scale = length > T(0) ? (dot(plane, nearest.offset) < T(0) ? T(-1) : T(1)) / length : T(0);
  const Vec3<T> change = cross(end.b - now.b, now.c) + cross(now.b, end.c - now.c);
  return {scale * plane, scale * (plane + change)};
}

/// Returns the offset's direction; with a supporting edge, the part that stays perpendicular to the edge as it turns.
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

/// Returns the fraction of [begin, end] during which n . r stays above `gap` |n|. |n| is convex in time, so the chord
/// of its values is above it. The difference from that chord is a quadratic.
template <class T>
SOFTCD_HD T clear_fraction(const MovingDirection<T>& n, T gap, T end_gap, Vec3<T> r_begin, Vec3<T> r_end) {
  const T g0 = dot(n.begin, r_begin) - gap;
  const T g1 = T(0.5) * ((dot(n.begin, r_end) + dot(n.end, r_begin)) - (gap + end_gap));
  const T g2 = dot(n.end, r_end) - end_gap;
  return g0 > T(0) ? first_root(g0, g1, g2) : T(0);
}

/// Returns the fraction of the time from `now` to `end` during which the features stay farther apart than `margin` plus
/// half the tolerance. No pair of their vertices comes closer along the direction n, and hence no pair of points.
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

/// Returns the longest step along the offset or the plane's normal, as a clear_fraction. Every direction is valid,
/// whatever its origin: a poor one makes a short step.
template <ContactKind kKind, class T>
SOFTCD_HD T advance(const Motion<T>& motion, const RelativePair<T>& now, const RelativePair<T>& end,
                    const Nearest<T>& nearest) {
  const T fraction = clear_fraction<kKind>(motion, now, end, offset_direction<kKind>(now, end, nearest));
  return fraction < T(1)
             ? larger(clear_fraction<kKind>(motion, now, end, plane_direction<kKind>(now, end, nearest)), fraction)
             : fraction;
}

/// Returns the longest step in a motion that is followed from beginning to end, as a clear_fraction. The third
/// direction lengthens few steps, but mostly in the motions that take many.
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

/// The touch of two features, and their offset before it.
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

/// Returns an upper bound of the distance by which the features may approach each other from `now` to `end`. None of
/// their points moves further than the ends of a, b and c together.
template <class T>
SOFTCD_HD T most_approach(const RelativePair<T>& now, const RelativePair<T>& end) {
  const auto length_at_most = [](Vec3<T> p) { return magnitude(p.x) + magnitude(p.y) + magnitude(p.z); };
  return length_at_most(end.a - now.a) + length_at_most(end.b - now.b) + length_at_most(end.c - now.c);
}

/// Finds the first time from `begin` to find_end() at which the features are within reach. Its steps never skip such a
/// time. It calls find_end() only if that is not `begin`. A coplanar stretch is usually short, and nothing comes near
/// in it.
template <ContactKind kKind, class T, class FindEnd>
SOFTCD_HD Touch<T> first_touch(const Motion<T>& motion, T begin, const FindEnd& find_end) {
  Touch<T> touch = touch_nowhere<T>();
  touch.is_settled = false;
  T t = begin;
  T end = begin;
  RelativePair<T> last{};
  for (int step = 0; step < kMaxAdvances; ++step) {
    const RelativePair<T> now = motion.at(t);
    touch.time = t;
    touch.nearest = nearest<kKind>(now);
    const T distance = square_root(touch.nearest.squared_distance);
    if (distance <= motion.reach()) {
      touch.is_settled = true;
      break;
    }
    if (step == 0) {
      end = find_end();
      last = motion.at(end);
    }
    if (distance > motion.reach() + most_approach(now, last)) {
      return touch;
    }
    if (distance > T(4) * motion.tolerance) {
      touch.approach = touch.nearest.offset;
    }
    const T fraction = advance<kKind>(motion, now, last, touch.nearest);
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

/// Finds the first time at which the features are within reach, from beginning to end. Its steps never skip such a
/// time. Motions take 1 to 64 steps, most of them few: a GPU's threads continue with other motions as they finish.
template <ContactKind kKind, class T>
class ApproachSearch {
 public:
  ApproachSearch() = default;
  SOFTCD_HD explicit ApproachSearch(const Motion<T>& motion)
      : motion_(motion), touch_(touch_nowhere<T>()), t_(T(0)), step_(0) {
    touch_.is_settled = false;
  }

  SOFTCD_HD const Motion<T>& motion() const { return motion_; }
  /// Returns the touch. Call it after advance() has returned true.
  SOFTCD_HD const Touch<T>& touch() const { return touch_; }

  /// Makes a step. Returns whether it was the last.
  SOFTCD_HD bool advance() {
    const RelativePair<T> now = motion_.at(t_);
    touch_.time = t_;
    touch_.nearest = nearest<kKind>(now);
    const T distance = square_root(touch_.nearest.squared_distance);
    if (distance <= motion_.reach()) {
      touch_.is_settled = true;
      return hit();
    }
    if (distance > T(4) * motion_.tolerance) {
      touch_.approach = touch_.nearest.offset;
    }
    const T fraction = advance_far<kKind>(motion_, now, motion_.at(T(1)), touch_.nearest, step_);
    if (fraction >= T(1)) {
      return true;
    }
    const T next = smaller(t_ + fraction * (T(1) - t_), T(1));
    if (!(next > t_)) {
      return hit();
    }
    t_ = next;
    return ++step_ == kMostApproachSteps && hit();
  }

 private:
  SOFTCD_HD bool hit() {
    touch_.is_hit = true;
    return true;
  }

  Motion<T> motion_;
  Touch<T> touch_;
  T t_;
  int step_;
};

template <ContactKind kKind, class T>
SOFTCD_HD Touch<T> touch_at(const Motion<T>& motion, const RelativePair<T>& pair, T t) {
  Touch<T> touch = touch_nowhere<T>();
  touch.time = t;
  touch.nearest = nearest<kKind>(pair);
  touch.is_hit = square_root(touch.nearest.squared_distance) <= motion.reach();
  return touch;
}

}  // namespace softcd::detail

#include "body_positions.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace softcd {
namespace {

/// Beyond this, sums of two coordinates might overflow float32.
constexpr double kLargestCoordinate = 1.0e37;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

bool is_usable(const Vec3d& p) {
  return std::abs(p.x) <= kLargestCoordinate && std::abs(p.y) <= kLargestCoordinate &&
         std::abs(p.z) <= kLargestCoordinate;
}

template <class T>
Vec3d load(const Positions& positions, std::size_t vertex) {
  T x[3];
  std::memcpy(x, static_cast<const std::byte*>(positions.data()) + vertex * positions.stride(), sizeof(x));
  return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
}

double rounding_of(double x) {
  // g++ 12 forgets to round where it vectorises the conversion to and fro.
  const volatile float rounded = static_cast<float>(x);
  return x - static_cast<double>(rounded);
}

double squared_rounding(Vec3d exact) {
  return squared_norm(Vec3d{rounding_of(exact.x), rounding_of(exact.y), rounding_of(exact.z)});
}

/// Writes one position relative to the origin. Floats lose nothing, see origin_of.
template <bool kMayRound>
void place(const Vec3d& x, bool is_finite, const Vec3d& origin, Vec3f& out, double& most_squared_rounding) {
  if (!is_finite) {
    out = {kNaN, kNaN, kNaN};
    return;
  }
  const Vec3d exact = x - origin;
  out = vec3_cast<float>(exact);
  if constexpr (kMayRound) most_squared_rounding = std::max(most_squared_rounding, squared_rounding(exact));
}

void survey_end(const Vec3d& x, bool is_finite, EndSurvey& survey) {
  if (is_finite) {
    survey.extent.extend(x);
  } else {
    ++survey.stray_count;
  }
}

void survey_way(const Vec3d& x_t0, const Vec3d& x_t1, StepSurvey& survey) {
  survey.moves |= !(x_t0 == x_t1);
  survey.squared_move = std::max(survey.squared_move, squared_norm(x_t1 - x_t0));
}

/// One end, of which the origin was another one.
void move_end(Vec3d from, Vec3d to, const std::vector<Vec3d>& full, std::size_t count, Vec3f* x, EndSurvey& survey) {
  survey.squared_rounding = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (full.empty()) {
      x[i] = vec3_cast<float>((vec3_cast<double>(x[i]) + from) - to);
    } else {
      place<true>(full[i], is_usable(full[i]), to, x[i], survey.squared_rounding);
    }
  }
}

double origin_of(double lo, double hi) {
  const auto centre = static_cast<double>(static_cast<float>(0.5 * (lo + hi)));
  const bool is_far = centre > 0 ? lo >= 0.5 * centre && hi <= 2 * centre : hi <= 0.5 * centre && lo >= 2 * centre;
  return is_far ? centre : 0.0;
}

}  // namespace

void Extent::extend(const Vec3d& low, const Vec3d& high) {
  lo = {std::min(lo.x, low.x), std::min(lo.y, low.y), std::min(lo.z, low.z)};
  hi = {std::max(hi.x, high.x), std::max(hi.y, high.y), std::max(hi.z, high.z)};
}

void EndSurvey::merge(const EndSurvey& other) {
  extent.extend(other.extent);
  stray_count += other.stray_count;
  squared_rounding = std::max(squared_rounding, other.squared_rounding);
}

void StepSurvey::merge(const StepSurvey& other) {
  t0.merge(other.t0);
  t1.merge(other.t1);
  squared_move = std::max(squared_move, other.squared_move);
  moves |= other.moves;
}

void BodyPositions::set(const Positions& x_t0, const Positions& x_t1) {
  if (x_t1.count() == 0) {
    are_set_ = true;
    return;
  }
  const bool is_one = x_t0.data() == x_t1.data() && (x_t0.stride() == x_t1.stride() || x_t1.count() < 2);
  if (x_t1.is_double()) {
    full_t1_.reserve(x_t1.count());
    if (!is_one) full_t0_.reserve(x_t1.count());
  }
  new_t0_ = x_t0;
  new_t1_ = x_t1;
  have_two_ends_ = !is_one;
}

template <class T, bool kNeedsT0>
StepSurvey BodyPositions::read_as(std::size_t begin, std::size_t end, Vec3d origin, PositionArrays out) {
  constexpr bool kIsDouble = std::is_same_v<T, double>;
  StepSurvey survey;
  for (std::size_t i = begin; i < end; ++i) {
    const Vec3d x_t1 = load<T>(new_t1_, i);
    if constexpr (kIsDouble) full_t1_[i] = x_t1;
    const bool is_t1_finite = is_usable(x_t1);
    survey_end(x_t1, is_t1_finite, survey.t1);
    place<kIsDouble>(x_t1, is_t1_finite, origin, out.x_t1[i], survey.t1.squared_rounding);
    if (!have_two_ends_) continue;
    const Vec3d x_t0 = load<T>(new_t0_, i);
    if constexpr (kIsDouble) full_t0_[i] = x_t0;
    if constexpr (kNeedsT0) {
      const bool is_t0_finite = is_usable(x_t0);
      survey_end(x_t0, is_t0_finite, survey.t0);
      place<kIsDouble>(x_t0, is_t0_finite, origin, out.x_t0[i], survey.t0.squared_rounding);
      if (is_t0_finite && is_t1_finite) survey_way(x_t0, x_t1, survey);
    } else if constexpr (!kIsDouble) {
      out.x_t0[i] = vec3_cast<float>(x_t0);
    }
  }
  if (!have_two_ends_) survey.t0 = survey.t1;
  return survey;
}

StepSurvey BodyPositions::read(std::size_t begin, std::size_t end, Vec3d origin, bool needs_t0, PositionArrays out) {
  if (new_t1_.is_double()) {
    return needs_t0 ? read_as<double, true>(begin, end, origin, out) : read_as<double, false>(begin, end, origin, out);
  }
  return needs_t0 ? read_as<float, true>(begin, end, origin, out) : read_as<float, false>(begin, end, origin, out);
}

void BodyPositions::prepare_reading() {
  const std::size_t full_count = new_t1_.is_double() ? new_t1_.count() : 0;
  const auto make_room = [](std::vector<Vec3d>& full, std::size_t count) {
    if (count == 0) full = {};
    full.resize(count);
  };
  make_room(full_t1_, full_count);
  make_room(full_t0_, have_two_ends_ ? full_count : 0);
}

void BodyPositions::finish_reading(bool needs_t0) {
  are_set_ = true;
  is_t0_placed_ = have_two_ends_ && needs_t0;
  new_t0_ = new_t1_ = Positions();
}

void BodyPositions::move_origin(Vec3d from, Vec3d to, std::size_t count, PositionArrays out) {
  move_end(from, to, full_t1_, count, out.x_t1, survey_.t1);
  if (!have_two_ends_) {
    survey_.t0 = survey_.t1;
    if (is_t0_placed_) std::copy_n(out.x_t1, count, out.x_t0);
  } else if (is_t0_placed_) {
    move_end(from, to, full_t0_, count, out.x_t0, survey_.t0);
  }
}

/// As it was given.
Vec3d BodyPositions::unplaced_t0(std::size_t vertex, PositionArrays arrays) const {
  return full_t0_.empty() ? vec3_cast<double>(arrays.x_t0[vertex]) : full_t0_[vertex];
}

/// `origin` is what x_t1 is relative to.
void BodyPositions::survey_t0(Vec3d origin, std::size_t count, PositionArrays arrays) {
  if (!have_two_ends_) return;
  survey_.t0 = {};
  survey_.moves = false;
  survey_.squared_move = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d x_t1 = full_t1_.empty() ? vec3_cast<double>(arrays.x_t1[i]) + origin : full_t1_[i];
    const Vec3d x_t0 = unplaced_t0(i, arrays);
    survey_end(x_t0, is_usable(x_t0), survey_.t0);
    if (is_usable(x_t0) && is_usable(x_t1)) survey_way(x_t0, x_t1, survey_);
  }
}

void BodyPositions::place_t0(Vec3d origin, std::size_t count, PositionArrays out) {
  is_t0_placed_ = true;
  if (!have_two_ends_) {
    std::copy_n(out.x_t1, count, out.x_t0);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d x_t0 = unplaced_t0(i, out);
    if (full_t0_.empty()) {
      place<false>(x_t0, is_usable(x_t0), origin, out.x_t0[i], survey_.t0.squared_rounding);
    } else {
      place<true>(x_t0, is_usable(x_t0), origin, out.x_t0[i], survey_.t0.squared_rounding);
    }
  }
}

Vec3d origin_of(const Extent& scene) {
  return {origin_of(scene.lo.x, scene.hi.x), origin_of(scene.lo.y, scene.hi.y), origin_of(scene.lo.z, scene.hi.z)};
}

}  // namespace softcd

#include "body_positions.hpp"

#include <algorithm>

namespace softcd {
namespace {

/// Moves the positions at one end from one origin to another.
void move_end(Vec3d from, Vec3d to, const std::vector<Vec3d>& full, std::size_t count, Vec3f* x, EndSurvey& survey) {
  survey.is_rounded = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (full.empty()) {
      x[i] = vec3_cast<float>((vec3_cast<double>(x[i]) + from) - to);
    } else {
      x[i] = placed(full[i], to);
      survey_rounding<double>(full[i], to, survey);
    }
  }
}

}  // namespace

void BodyPositions::set(const Positions& x_t0, const Positions& x_t1) {
  if (x_t1.count() == 0) {
    are_set_ = true;
    return;
  }
  const bool is_one = x_t0.data() == x_t1.data() && (x_t0.stride() == x_t1.stride() || x_t1.count() < 2);
  if (x_t1.is_double() && !x_t1.is_on_device()) {
    full_t1_.reserve(x_t1.count());
    if (!is_one) full_t0_.reserve(x_t1.count());
  }
  new_t0_ = x_t0;
  new_t1_ = x_t1;
  are_new_ = true;
  have_two_ends_ = !is_one;
}

template <class T, bool kNeedsT0>
StepSurvey BodyPositions::read_as(std::size_t begin, std::size_t end, Vec3d origin, PositionArrays out) {
  constexpr bool kIsDouble = std::is_same_v<T, double>;
  const SurveyedVertices vertices = {given(new_t0_), given(new_t1_), begin, end, have_two_ends_};
  StepSurvey survey;
  for (std::size_t i = begin; i < end; ++i) {
    survey_vertex<T>(vertices, i, origin, kNeedsT0, survey);
    const Vec3d x_t1 = position_at<T>(vertices.x_t1, i);
    if constexpr (kIsDouble) full_t1_[i] = x_t1;
    out.x_t1[i] = placed(x_t1, origin);
    if (!have_two_ends_) continue;
    const Vec3d x_t0 = position_at<T>(vertices.x_t0, i);
    if constexpr (kIsDouble) full_t0_[i] = x_t0;
    if constexpr (kNeedsT0) {
      out.x_t0[i] = placed(x_t0, origin);
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
  are_new_ = false;
  is_t0_placed_ = needs_t0 && (have_two_ends_ || are_on_device());
  if (!are_on_device()) new_t0_ = new_t1_ = Positions();
}

void BodyPositions::copy_full(std::size_t begin, std::size_t end, Vec3d origin, PositionArrays arrays, bool with_t0,
                              Vec3d* out_t0, Vec3d* out_t1) const {
  const auto copy = [&](const std::vector<Vec3d>& full, const Vec3f* x, Vec3d* out) {
    for (std::size_t i = begin; i < end; ++i) out[i] = full.empty() ? vec3_cast<double>(x[i]) + origin : full[i];
  };
  copy(full_t1_, arrays.x_t1, out_t1);
  if (!with_t0) return;
  if (have_two_ends_) {
    copy(full_t0_, arrays.x_t0, out_t0);
  } else {
    std::copy(out_t1 + begin, out_t1 + end, out_t0 + begin);
  }
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

/// Returns the position at t0 as it was given.
Vec3d BodyPositions::unplaced_t0(std::size_t vertex, PositionArrays arrays) const {
  return full_t0_.empty() ? vec3_cast<double>(arrays.x_t0[vertex]) : full_t0_[vertex];
}

/// Surveys t0. `origin` is the origin of x_t1.
void BodyPositions::survey_t0(Vec3d origin, std::size_t count, PositionArrays arrays) {
  if (!have_two_ends_) return;
  survey_.t0 = {};
  survey_.moves = false;
  survey_.squared_move = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d x_t1 = full_t1_.empty() ? vec3_cast<double>(arrays.x_t1[i]) + origin : full_t1_[i];
    const Vec3d x_t0 = unplaced_t0(i, arrays);
    survey_end(x_t0, survey_.t0);
    survey_way(x_t0, x_t1, survey_);
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
    if (!full_t0_.empty()) survey_rounding<double>(x_t0, origin, survey_.t0);
    out.x_t0[i] = placed(x_t0, origin);
  }
}

}  // namespace softcd

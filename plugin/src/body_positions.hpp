#pragma once

#include <cstdint>
#include <vector>

#include "softcd/mesh/foreseen_positions.hpp"
#include "softcd/positions.hpp"

namespace softcd {

/// Bytes of one position.
inline std::size_t position_size(const Positions& positions) {
  return positions.is_double() ? sizeof(Vec3d) : sizeof(Vec3f);
}

inline GivenPositions given(const Positions& positions) {
  return {positions.data(), positions.stride(), positions.is_double()};
}

/// Where the scene's arrays have a body's positions: relative to the scene's origin, NaN where not finite.
struct PositionArrays {
  Vec3f* x_t0;
  Vec3f* x_t1;
};

/// A body's positions at both ends of a step: the caller's memory until they are read, then the scene's arrays, and,
/// where they are double, what they are in full. As long as nobody looks at t0 it is kept as it was given. Positions on
/// a device stay in the caller's memory, which is read whenever they are needed.
class BodyPositions {
 public:
  bool are_set() const { return are_set_ || are_new_; }
  bool are_new() const { return are_new_; }
  bool are_double() const { return are_new_ || are_on_device() ? new_t1_.is_double() : !full_t1_.empty(); }
  bool are_on_device() const { return new_t1_.is_on_device(); }
  /// The caller's memory, and whether t0 is not t1.
  const Positions& given_t0() const { return new_t0_; }
  const Positions& given_t1() const { return new_t1_; }
  bool have_two_ends() const { return have_two_ends_; }
  bool is_t0_placed() const { return is_t0_placed_; }
  /// Of what was read last.
  const StepSurvey& survey() const { return survey_; }

  /// Takes ends of one type and length. Changes nothing when it throws std::bad_alloc.
  void set(const Positions& x_t0, const Positions& x_t1);
  /// As if they had never been set.
  void forget() { *this = {}; }

  /// Before what was set is read, once nothing else needs what was read before. Allocates nothing.
  void prepare_reading();
  /// Reads the vertices [begin, end) of what was set.
  StepSurvey read(std::size_t begin, std::size_t end, Vec3d origin, bool needs_t0, PositionArrays out);
  /// What was seen of all of them.
  void set_survey(const StepSurvey& survey) { survey_ = survey; }
  /// The caller's memory is not looked at any more, unless it is a device's.
  void finish_reading(bool needs_t0);
  /// What is on a device is to be looked at anew.
  void distrust_device() { are_new_ |= are_on_device(); }
  /// Writes the vertices [begin, end) as they were given, which are read, and not on a device; t0 where it is placed
  /// and `with_t0`. `origin` is what the arrays are relative to.
  void copy_full(std::size_t begin, std::size_t end, Vec3d origin, PositionArrays arrays, bool with_t0, Vec3d* out_t0,
                 Vec3d* out_t1) const;
  /// Moves all that were read before from one origin to another.
  void move_origin(Vec3d from, Vec3d to, std::size_t count, PositionArrays out);
  /// Two steps where t0 was not needed before.
  void survey_t0(Vec3d origin, std::size_t count, PositionArrays arrays);
  void place_t0(Vec3d origin, std::size_t count, PositionArrays out);

 private:
  template <class T, bool kNeedsT0>
  StepSurvey read_as(std::size_t begin, std::size_t end, Vec3d origin, PositionArrays out);
  Vec3d unplaced_t0(std::size_t vertex, PositionArrays arrays) const;

  Positions new_t0_, new_t1_;
  std::vector<Vec3d> full_t0_, full_t1_;  ///< empty where positions are floats
  StepSurvey survey_;
  bool are_set_ = false;
  bool are_new_ = false;
  bool have_two_ends_ = false;  ///< not one and the same array
  bool is_t0_placed_ = false;
};

}  // namespace softcd

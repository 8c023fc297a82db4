#pragma once

#include <cstdint>
#include <vector>

#include "softcd/mesh/predicted_positions.hpp"
#include "softcd/positions.hpp"

namespace softcd {

/// Returns the number of bytes of one position.
inline std::size_t position_size(const Positions& positions) {
  return positions.is_double() ? sizeof(Vec3d) : sizeof(Vec3f);
}

inline GivenPositions given(const Positions& positions) {
  return {positions.data(), positions.stride(), positions.is_double()};
}

/// The scene's arrays of a body's positions: relative to the scene's origin, NaN where not finite.
struct PositionArrays {
  Vec3f* x_t0;
  Vec3f* x_t1;
};

/// A body's positions at both ends of a step. They are in the caller's memory until they are read, then in the scene's
/// arrays; double positions are also kept in double. Positions at t0 are kept unplaced as long as no detection needs
/// them. Positions on a device stay in the caller's memory, and are read there whenever they are needed.
class BodyPositions {
 public:
  bool are_set() const { return are_set_ || are_new_; }
  bool are_new() const { return are_new_; }
  bool are_double() const { return are_new_ || are_on_device() ? new_t1_.is_double() : !full_t1_.empty(); }
  bool are_on_device() const { return new_t1_.is_on_device(); }
  /// Return the caller's memory; t0 and t1 may be the same.
  const Positions& given_t0() const { return new_t0_; }
  const Positions& given_t1() const { return new_t1_; }
  bool have_two_ends() const { return have_two_ends_; }
  bool is_t0_placed() const { return is_t0_placed_; }
  /// Returns the summary of the positions that were read last.
  const StepSurvey& survey() const { return survey_; }

  /// Sets both ends, which have one type and length. Changes nothing when it throws std::bad_alloc.
  void set(const Positions& x_t0, const Positions& x_t1);
  /// Returns to the state before positions were first set.
  void forget() { *this = {}; }

  /// Prepares to read the new positions. Call it once the old ones are no longer needed. Allocates nothing.
  void prepare_reading();
  /// Reads the vertices [begin, end) of the new positions.
  StepSurvey read(std::size_t begin, std::size_t end, Vec3d origin, bool needs_t0, PositionArrays out);
  /// Sets the summary of all positions.
  void set_survey(const StepSurvey& survey) { survey_ = survey; }
  /// Ends the reading. The caller's memory is not used any more, unless it is a device's.
  void finish_reading(bool needs_t0);
  /// Marks positions on a device as unread, so that they are surveyed again.
  void distrust_device() { are_new_ |= are_on_device(); }
  /// Writes the vertices [begin, end) as they were given. They must have been read, and must not be on a device. Writes
  /// t0 only if it is placed and `with_t0`. `origin` is the origin of the arrays.
  void copy_full(std::size_t begin, std::size_t end, Vec3d origin, PositionArrays arrays, bool with_t0, Vec3d* out_t0,
                 Vec3d* out_t1) const;
  /// Moves all positions that were read before from one origin to another.
  void move_origin(Vec3d from, Vec3d to, std::size_t count, PositionArrays out);
  /// These two steps add t0, where it was not needed before.
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
  bool have_two_ends_ = false;  ///< t0 and t1 are different arrays
  bool is_t0_placed_ = false;
};

}  // namespace softcd

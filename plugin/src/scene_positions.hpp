#pragma once

#include <exception>
#include <vector>

#include "body.hpp"
#include "extent_prediction.hpp"
#include "host_array.hpp"

namespace softcd {

class SceneLayout;

/// The positions that the queries and probes of a scene need.
struct NeededPositions {
  bool t0 = false;     ///< contacts there, or on the path from there
  bool t1 = false;     ///< contacts there, or on the path to there
  bool moves = false;  ///< the distance that vertices move from one to the other

  bool needs_t0() const { return t0 || moves; }
  bool needs_t1() const { return t1 || moves; }

  friend bool operator==(const NeededPositions&, const NeededPositions&) = default;
};

/// The positions of a scene's bodies. Reads positions on the host into the layout's arrays, once, relative to the
/// scene's origin, and computes the extents of all. Positions on a device stay there: the host waits until a reader has
/// surveyed them, or uses a prediction. Owned by SceneStore.
class ScenePositions {
 public:
  explicit ScenePositions(SceneLayout& layout) : layout_(layout) {}

  /// Makes memory for positions accessible to CUDA devices from now on.
  void share();
  /// Drops predictions, because something other than positions has changed.
  void forget_prediction() { prediction_.forget(); }
  /// Reads the new positions that `needs` names. Afterwards the caller's memory on the host is no longer needed, even
  /// if this throws an exception of `reader`; the next call then surveys the device again. `reader` may be null if no
  /// positions are on a device. If it `may_predict`, judge_predicted() must follow before anything else changes.
  void read(const NeededPositions& needs, DevicePositionReader* reader, bool may_predict);
  /// Returns whether the last read() used predictions that have not been judged.
  bool has_predicted() const { return !predicted_blocks_.empty(); }
  /// Returns whether all predictions were right. Call it after a detector that used them has finished. If not, or if
  /// `reader` throws, the next read() surveys the positions.
  bool judge_predicted(DevicePositionReader& reader);
  /// Makes the next read() survey the positions that were predicted.
  void doubt_predicted() noexcept;
  /// Copies positions on a device into the arrays, as if they had been given on the host.
  void take_to_host(DevicePositionReader& reader);
  /// Returns the body's vertices that are not finite at the ends that `needs` names, ascending. Records the body for
  /// bodies_with_new_strays() if some of them are new. Queries may need different ends in turn; a vertex that one query
  /// has reported is not reported again.
  std::vector<std::uint32_t> find_strays(Body& body, const NeededPositions& needs);
  /// Returns the bodies that find_strays() has recorded since the last read().
  const std::vector<const Body*>& bodies_with_new_strays() const { return bodies_with_new_strays_; }

  bool are_on_device() const;
  /// Returns whether some positions on a device are doubles that were not surveyed.
  bool has_new_doubles_on_device() const;
  Vec3d origin() const { return origin_; }
  /// Returns whether a float in the arrays differs from the position that was given, at one end.
  bool are_rounded_at(bool t0) const;
  /// Returns the extent of all positions at one end.
  Extent extent_at(bool t0) const;
  /// Returns a number that changes with the positions; 0 at first.
  std::uint64_t revision() const { return revision_; }
  /// Returns a number that changes where pairs of bodies may change; 0 if that is unknown.
  std::uint64_t selection_number() const { return selection_number_; }

  /// Fills full_t0() and full_t1(), except for positions on a device. Returns a number that changes with them; never 0.
  std::uint64_t fill_full();
  Span<const Vec3d> full_t0() const { return full_t0_.view(); }
  Span<const Vec3d> full_t1() const { return full_t1_.view(); }
  /// Appends all full positions, for a detector without a copy of them.
  void append_full(SceneChanges& changes) const;
  /// Appends positions that changed since forget_changes(), those at t0 if `with_t0`; if `all`, every body's.
  void append_changes(SceneChanges& changes, bool all, bool with_t0) const;
  void forget_changes(bool with_t0);

 private:
  /// A run of one body's vertices, the unit of parallel work.
  struct Block {
    Body* body;
    std::size_t begin, end;
  };

  template <class IsConcerned>
  std::vector<Block> blocks_of(const IsConcerned& is_concerned, std::size_t size) const;
  static void append_blocks(Body& body, std::size_t size, std::vector<Block>& blocks);
  static std::vector<SurveyedVertices> surveyed(const std::vector<Block>& blocks);
  static void merge_surveys(const std::vector<Block>& blocks, Span<const StepSurvey> surveys);
  static void wait_until_ready(const Body& body, DevicePositionReader& reader);

  void read_and_survey(DevicePositionReader* reader);
  void prepare_reading();
  void read_on_host(Vec3d origin);
  template <class IsConcerned>
  std::exception_ptr survey_on_device(DevicePositionReader* reader, Vec3d origin, const IsConcerned& is_concerned);
  void finish_reading(Body& body, Vec3d origin);
  bool lacks_t0(const Body& body) const;
  StepSurvey read_block(const Block& block, Vec3d origin);
  void take_to_host(Body& body, DevicePositionReader& reader);
  void copy_full(const Block& block);

  bool can_predict(const NeededPositions& needs) const;
  void predict(DevicePositionReader& reader);

  SceneLayout& layout_;
  Vec3d origin_{0, 0, 0};
  NeededPositions needs_;  ///< when positions were read last
  std::uint64_t revision_ = 0;
  HostArray<Vec3d> full_t0_, full_t1_;
  std::uint64_t full_revision_ = 0;  ///< of the scene, when they were filled; 0: they are not
  std::vector<const Body*> bodies_with_new_strays_;
  ExtentPrediction prediction_;
  std::vector<Block> predicted_blocks_;  ///< with predicted summaries; bodies keep their places until the verdict
  PredictionVerdict verdict_;            ///< the verdict on the predictions
  std::uint64_t predicted_number_ = 0;   ///< identifies the prediction, and its bodies, that the last read() used
  std::vector<std::size_t> predicted_bodies_;
  std::uint64_t selection_number_ = 0, last_selection_number_ = 0;
};

}  // namespace softcd

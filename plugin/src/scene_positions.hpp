#pragma once

#include <exception>
#include <vector>

#include "body.hpp"
#include "foresight.hpp"
#include "host_array.hpp"

namespace softcd {

class SceneLayout;

/// Which positions the queries and probes of a scene need.
struct LookedAt {
  bool t0 = false;     ///< contacts there, or on the way from there
  bool t1 = false;     ///< contacts there, or on the way to there
  bool moves = false;  ///< how far vertices move from one to the other

  bool needs_t0() const { return t0 || moves; }
  bool needs_t1() const { return t1 || moves; }

  friend bool operator==(const LookedAt&, const LookedAt&) = default;
};

/// The positions of a scene's bodies. Reads those on the host into the layout's arrays, once, relative to the scene's
/// origin, and finds the extents of all. Positions on a device stay there: the host waits until a reader has surveyed
/// them, or takes them to be where they are foreseen.
class ScenePositions {
 public:
  explicit ScenePositions(SceneLayout& layout) : layout_(layout) {}

  /// Memory for positions is a CUDA device's, too, from now on.
  void share();
  /// Forgets what is foreseen, as something else than positions has changed.
  void forget_foresight() { foresight_.forget(); }
  /// Reads what was set, for these needs. Afterwards the caller's memory on the host is not needed, even if this
  /// throws what `reader` throws; then the next call surveys the device again. `reader` may be null if no positions
  /// are on a device. If it `may_foresee`, judge_foreseen() has to follow before anything else is changed.
  void read(const LookedAt& needs, DevicePositionReader* reader, bool may_foresee);
  /// Whether the last read() has foreseen something, on which there is no judgement.
  bool has_foreseen() const { return !foreseen_blocks_.empty(); }
  /// Returns whether all positions are as foreseen, once a detector that was told of them has finished. If not, or if
  /// `reader` throws, the next read() surveys them.
  bool judge_foreseen(DevicePositionReader& reader);
  /// Has the next read() survey what was foreseen.
  void doubt_foreseen() noexcept;
  /// Copies positions on a device into the arrays, as if they had been given on the host.
  void take_to_host(DevicePositionReader& reader);
  /// Returns the body's vertices that are not finite where `needs` looks, ascending. Notes the body if some of them are
  /// new: queries that look at other ends take turns, and what one has reported is not reported again.
  std::vector<std::uint32_t> find_strays(Body& body, const LookedAt& needs);
  /// The bodies that were noted since the last read().
  const std::vector<const Body*>& bodies_with_new_strays() const { return bodies_with_new_strays_; }

  bool are_on_device() const;
  /// Whether some positions on a device are doubles that were not surveyed.
  bool has_new_doubles_on_device() const;
  Vec3d origin() const { return origin_; }
  /// The extent of all positions at one end.
  Extent extent_at(bool t0) const;
  /// Changes with the positions; 0 at first.
  std::uint64_t revision() const { return revision_; }
  /// Changes where pairs of bodies may be others than they were; 0 if that is not known.
  std::uint64_t selection_number() const { return selection_number_; }

  /// Fills full_t0() and full_t1(), except for positions on a device. Returns a number that changes with them; never 0.
  std::uint64_t fill_full();
  Span<const Vec3d> full_t0() const { return full_t0_.view(); }
  Span<const Vec3d> full_t1() const { return full_t1_.view(); }
  /// Appends all full positions, for a detector that does not know them.
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
  std::vector<Block> blocks_of(const IsConcerned& is_concerned) const;
  static void append_blocks(Body& body, std::vector<Block>& blocks);
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

  bool can_foresee(const LookedAt& needs) const;
  void foresee(DevicePositionReader& reader);

  SceneLayout& layout_;
  Vec3d origin_{0, 0, 0};
  LookedAt needs_;  ///< when positions were read last
  std::uint64_t revision_ = 0;
  HostArray<Vec3d> full_t0_, full_t1_;
  std::uint64_t full_revision_ = 0;  ///< of the scene, when they were filled; 0: they are not
  std::vector<const Body*> bodies_with_new_strays_;
  Foresight foresight_;
  std::vector<Block> foreseen_blocks_;  ///< whose surveys are foreseen; bodies stay where they are meanwhile
  ForeseenVerdict verdict_;             ///< on them
  std::uint64_t foreseen_number_ = 0;   ///< what the last read() has foreseen, and for which bodies
  std::vector<std::size_t> foreseen_bodies_;
  std::uint64_t selection_number_ = 0, last_selection_number_ = 0;
};

}  // namespace softcd

#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "softcd/pipeline/lists.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/kept_pairs.hpp"

/// The data that detections keep for later ones. pair_keeping.hpp decides what is kept and reused.
namespace softcd {

/// Counts of the kept pairs' detection, in the backend's memory.
struct KeptCounts {
  std::uint64_t pairs;
  GridParameters grid;
};

/// Stores the counts of a detection that keeps its pairs.
struct StoreKeptCounts {
  const Counters* counters;
  KeptCounts* kept;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    if (team.is_leader()) *kept = {counters->kept, counters->grid};
  }
};

/// Restores the counts for a detection that reuses kept pairs.
struct RestoreKeptCounts {
  const KeptCounts* kept;
  Counters* counters;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    if (!team.is_leader()) return;
    counters->kept = kept->pairs;
    counters->grid = kept->grid;
    counters->grid.active_triangles = static_cast<std::uint32_t>(counters->active);
  }
};

/// Whether the pairs that a query's detections keep are of use to later ones, and how much volumes should grow for
/// that. Keeping pairs costs about a tenth of a detection, and saves most of one.
class Usefulness {
 public:
  bool is_likely() const { return credit_ > 0; }
  float slack() const { return slack_; }

  /// Whether a detection should keep volumes to learn from: only now and then if many have taught nothing.
  bool wants_to_learn() { return lessons_in_vain_ < kMostInVain || ++detections_ % kSeldom == 0; }

  void confirm() {
    credit_ = kMostCredit;
    lessons_in_vain_ = 0;
  }
  void doubt() {
    if (credit_ == 0 || --credit_ > 0) return;
    slack_ = 0.0F;
    detections_to_rest_ = kRest;
  }

  /// Learns that no triangle moves further than `move` from one detection to the next. `radius` is the mean triangle's.
  void learn(float move, float radius) {
    slack_ = 0.0F;
    ++lessons_in_vain_;
    if (detections_to_rest_ > 0) {
      --detections_to_rest_;
    } else if (move > 0.0F && kFewestDetections * move <= kMostSlack * radius) {
      slack_ = std::min(kDetections * move, kMostSlack * radius);
      credit_ = std::max(credit_, 1);
      lessons_in_vain_ = 0;
    }
  }

 private:
  static constexpr int kMostCredit = 6;
  static constexpr int kRest = 32;
  static constexpr int kMostInVain = 8;
  static constexpr int kSeldom = 16;
  /// The number of detections that volumes should last, and that they must last for the pairs to pay.
  static constexpr float kDetections = 6.0F;
  static constexpr float kFewestDetections = 3.0F;
  /// In mean radii. More slack would add more pair tests than reuse saves.
  static constexpr float kMostSlack = 0.4F;

  int credit_ = 0;
  int detections_to_rest_ = 0;
  int lessons_in_vain_ = 0;  ///< in a row
  int detections_ = 0;       ///< since too many lessons were in vain
  float slack_ = 0.0F;
};

/// The number of detections whose results a detector keeps at the same time. A world of Bullet's has up to four queries
/// in turn: contacts of soft bodies, with meshes, with convex shapes, and crossings.
constexpr std::size_t kMostKept = 4;

/// The results that a detection keeps for later ones, of the same query and of others:
/// - the volumes of all triangles, grown by some slack;
/// - if likely to be of use, all pairs of triangles whose volumes overlap.
/// All pairs of triangles whose volumes lie within the kept ones are among the kept pairs.
template <class Backend>
struct KeptPairs {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;

  Buffer<Kdop18> volumes;
  List<Backend, DetectionCounter<&Counters::kept>, ArrayTarget<std::uint64_t>, Buffer<std::uint64_t>> pairs;
  Buffer<KeptCounts> counts;
  // See LookUpEscaped:
  Buffer<std::uint32_t> escaped;
  Buffer<EscapedGroup> escaped_groups;
  Buffer<SceneBody> grown_bodies;  ///< with partner boxes that the slack has grown
  /// The bodies and pairs of the kept detection, on the host; see SceneView.
  std::vector<SceneBody> bodies;
  std::vector<std::uint64_t> partner_begin;
  std::vector<std::uint32_t> partners;
  DetectionSettings settings{};
  std::uint64_t revision = 0;  ///< of the detector; 0: nothing is kept
  float mean_radius = 0.0F;    ///< of its triangles
  std::uint64_t number = 0;    ///< in the order in which they were kept
  bool has_pairs = false;
  float slack = 0.0F;
  int age = 0;                             ///< detections of the same query since
  std::shared_ptr<Usefulness> usefulness;  ///< of the query that kept it
  bool was_of_use = false;
  int misses = 0;  ///< comparisons in a row that it did not serve
};

/// The work that a detection does for later ones.
struct KeepingWork {
  bool compares = false;  ///< volumes with the kept ones
  bool measures_headroom = false;
  bool keeps_volumes = false;  ///< grown by `slack`
  bool keeps_pairs = false;
  bool looks_up_escaped = false;  ///< beside the kept pairs
  float slack = 0.0F;

  friend bool operator==(const KeepingWork&, const KeepingWork&) = default;
};

}  // namespace softcd

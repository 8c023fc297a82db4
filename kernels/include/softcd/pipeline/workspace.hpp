#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <tuple>
#include <vector>

#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/output.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/cell_ranges.hpp"
#include "softcd/stages/contact_order.hpp"
#include "softcd/stages/grid_parameters.hpp"
#include "softcd/stages/patches.hpp"
#include "softcd/stages/split_cells.hpp"

namespace softcd {

/// Counts of the lists that hold what comes between one chunk's tests and its contacts.
struct ChunkCounts {
  std::uint64_t patch_pairs, pairs, vt_candidates, ee_candidates;
};

/// Calls f with the same count of each of `counts`, for one count after the other.
template <class F, class... Counts>
SOFTCD_HD void for_each_count(const F& f, Counts&... counts) {
  // A count that is not named here does not compile.
  [[maybe_unused]] const auto& [patch_pairs, pairs, vt_candidates, ee_candidates] = ChunkCounts{};
  f(counts.patch_pairs...);
  f(counts.pairs...);
  f(counts.vt_candidates...);
  f(counts.ee_candidates...);
}

/// What is done with counts.
struct AddCount {
  SOFTCD_HD void operator()(std::uint64_t& sum, std::uint64_t count) const { sum += count; }
};
struct KeepLargerCount {
  SOFTCD_HD void operator()(std::uint64_t& most, std::uint64_t count) const { most = larger(most, count); }
};

/// Counts that a detection begins with.
struct SceneCounts {
  std::uint64_t triangles, vertex_triangle_neighbours, edge_edge_neighbours;

  friend bool operator==(const SceneCounts&, const SceneCounts&) = default;
};

/// Everything that is counted during a detection, in the backend's memory; cleared at its beginning, read at its end.
struct Counters {
  SceneCounts scene;
  std::uint64_t loose, splits, bigs, children, split_cells, entries, cells, tests;
  std::uint64_t flagged, contacts, unsettled;
  std::uint64_t contacts_in_runs, long_runs;  ///< see contact_order.hpp
  std::uint64_t all;       ///< no less than anything whose number the host knows; 0: see ClearCounters
  ChunkCounts chunk;       ///< of the current one
  ChunkCounts done, most;  ///< of the chunks before: together, and in one
  float earliest_toi;
  GridParameters grid;
  std::uint64_t active, escaped;             ///< triangles, see FindEscaped
  float headroom;                            ///< 0, or the least that is less: see MeasureHeadroom
  std::uint64_t kept;                        ///< pairs that a look keeps, or has kept
  std::uint64_t vt_contacts;                 ///< where contacts stay in the backend's memory
  std::uint32_t test_samples[kTestSamples];  ///< see TestSamples
};

/// Begins the next chunk.
struct NextChunk {
  Counters* counters;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    if (team.is_leader()) for_each_count(Next{}, counters->chunk, counters->done, counters->most);
  }

 private:
  struct Next {
    SOFTCD_HD void operator()(std::uint64_t& count, std::uint64_t& done, std::uint64_t& most) const {
      done += count;
      most = larger(most, count);
      count = 0;
    }
  };
};

/// Where positions are not as foreseen there is nothing: no work has an item.
struct ClearCounters {
  Counters* counters;
  SceneCounts scene;
  const std::uint32_t* is_as_foreseen;  ///< see ForeseenVerdict

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    if (!team.is_leader()) return;
    *counters = Counters{};
    counters->earliest_toi = 1.0F;
    if (is_as_foreseen != nullptr && *is_as_foreseen == 0) return;
    counters->scene = scene;
    counters->all = ~std::uint64_t{0};
  }
};

/// What a look says of the pairs that it keeps, in the backend's memory.
struct KeptCounts {
  std::uint64_t pairs;
  GridParameters grid;
};

/// Of a look that has kept its pairs.
struct StoreKeptCounts {
  const Counters* counters;
  KeptCounts* kept;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    if (team.is_leader()) *kept = {counters->kept, counters->grid};
  }
};

/// For a look that finds its pairs among those kept.
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

/// How many values a list was asked for, at once and by any chunk before, and how many it holds.
struct ListBound {
  const std::uint64_t* count;
  const std::uint64_t* most;
  std::uint64_t capacity;

  SOFTCD_HD bool holds_all() const { return *count <= capacity && *most <= capacity; }
};

/// The counter of a list of the whole detection, and of one chunk.
template <std::uint64_t Counters::*kMember>
struct DetectionCounter {
  static constexpr bool kIsOfChunk = false;
  static const std::uint64_t& most(const Counters& counters) { return counters.*kMember; }
  template <class Values>
  static SOFTCD_HD auto& in(Values& counters) {
    return counters.*kMember;
  }
};
template <std::uint64_t ChunkCounts::*kMember>
struct ChunkCounter {
  static constexpr bool kIsOfChunk = true;
  static const std::uint64_t& most(const Counters& counters) { return counters.most.*kMember; }
  template <class Values>
  static SOFTCD_HD auto& in(Values& counters) {
    return counters.chunk.*kMember;
  }
};

/// Stages number items with 32 bits. A list that would be longer is as one that memory does not suffice for: what it is
/// to hold has to be found in parts.
constexpr std::uint64_t kMostItems = 0xFFFFFFFF;

/// A growing list and its counter. `Columns` are the buffers behind it, all of one capacity.
template <class Backend, class Counter, class Target, class... Columns>
class List {
 public:
  /// It holds what comes between one chunk's tests and its contacts.
  static constexpr bool kIsOfChunk = Counter::kIsOfChunk;

  /// How many values were asked for.
  static std::uint64_t& counted(Counters& counters) { return Counter::in(counters); }
  static std::uint64_t counted(const Counters& counters) { return Counter::in(counters); }

  /// How many values the next stage may store.
  std::uint64_t capacity() const { return bound_; }
  /// As it was after another detection, as far as there is memory for it.
  void restore_capacity(std::uint64_t capacity) { bound_ = std::min(capacity, allocated_); }

  /// Keeps the first `kept` values. There will be room for a quarter more than asked for, so that slowly growing scenes
  /// seldom grow a list; for no more than that where memory does not suffice.
  void reserve(Backend& backend, std::uint64_t wanted, std::uint64_t kept) {
    if (wanted <= bound_) return;
    if (wanted > kMostItems) throw std::bad_alloc();
    if (roomy(wanted) <= allocated_) {
      bound_ = roomy(wanted);
      return;
    }
    bound_ = allocated_ = 0;  // until all columns have grown
    try {
      reserve_columns(backend, roomy(wanted), kept);
      allocated_ = roomy(wanted);
    } catch (const std::bad_alloc&) {
      reserve_columns(backend, wanted, kept);
      allocated_ = wanted;
    }
    bound_ = allocated_;
  }

  /// Uses no more of the list than a detection that counted `count` values would have room for. Work whose size the
  /// host does not know is sized by the capacity.
  void fit(std::uint64_t count) { bound_ = std::min(bound_, roomy(count)); }

  /// Undoes what sorting did to the addresses; the values are lost.
  void rewind() {
    std::apply([](auto&... column) { (column.rewind(), ...); }, columns_);
  }

  template <std::size_t I>
  auto& column() {
    return std::get<I>(columns_);
  }

  Appender<Target> appender(Counters* counters) {
    return {std::apply([](auto&... column) { return Target{column.data()...}; }, columns_), &Counter::in(*counters),
            bound_};
  }
  Count count(const Counters* counters) const { return {&Counter::in(*counters), bound_}; }
  ListBound bound(const Counters* counters) const {
    return {&Counter::in(*counters), &Counter::most(*counters), bound_};
  }

 private:
  void reserve_columns(Backend& backend, std::uint64_t bound, std::uint64_t kept) {
    std::apply([&](auto&... column) { (column.reserve(backend, bound, kept), ...); }, columns_);
  }

  /// A quarter more, rounded up to an eighth of an octave, so that it stays the same while counts change little.
  static std::uint64_t roomy(std::uint64_t count) {
    const std::uint64_t wanted = count == 0 ? 0 : count + count / 4 + 256;
    std::uint64_t step = 1;
    while (step * 16 <= wanted) step *= 2;
    return std::min(kMostItems, (wanted + step - 1) / step * step);
  }

  std::uint64_t allocated_ = 0;
  std::uint64_t bound_ = 0;
  std::tuple<Columns...> columns_;
};

/// The backend's copy of a scene, or, where the backend reads host memory, where it is; see SceneArrays.
template <class Backend>
struct SceneMirror {
  template <class T>
  using Mirror = typename Backend::template Mirror<T>;

  Mirror<Vec3f> x_t0, x_t1;
  Mirror<Vec3d> full_t0, full_t1;
  Mirror<Triangle> triangles;
  Mirror<TriangleEdges> triangle_edges;
  Mirror<Edge> edges;
  Mirror<Ownership> ownership;
  Mirror<std::uint32_t> patch_triangles;
  Mirror<std::uint32_t> triangle_body, vertex_body;
  Mirror<std::uint64_t> vertex_triangle_neighbours, edge_edge_neighbours;
  // See FeatureFilters:
  Mirror<VertexFilter> vertex_filters;
  Mirror<std::uint64_t> ring_begin;
  Mirror<std::uint32_t> ring_vertices;
  Mirror<Vec3f> x_rest;
};

constexpr std::size_t kListCount = 11;

/// The lists that stages append to. `Scheme` as ExactScheme.
template <class Backend, class Scheme>
struct Lists {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  template <class T>
  using SortBuffer = typename Backend::template SortBuffer<T>;
  template <class Counter, class T>
  using ArrayList = List<Backend, Counter, ArrayTarget<T>, Buffer<T>>;

  // Of the whole detection. In the order in which they grow: where memory is short, what no parts can make smaller
  // first.
  ArrayList<DetectionCounter<&Counters::bigs>, std::uint32_t> bigs;
  ArrayList<DetectionCounter<&Counters::loose>, std::uint32_t> loose;  ///< triangles of loose patches
  ArrayList<DetectionCounter<&Counters::splits>, typename Scheme::Split> splits;
  typename Scheme::template SplitCells<Backend> split_cells;
  List<Backend, DetectionCounter<&Counters::entries>, EntryTarget, SortBuffer<std::uint32_t>, SortBuffer<Entry>>
      entries;
  List<Backend, DetectionCounter<&Counters::flagged>, ArrayTarget<std::uint64_t>, SortBuffer<std::uint64_t>> flagged;
  ArrayList<DetectionCounter<&Counters::contacts>, FeatureContact> found;
  // Of one chunk.
  ArrayList<ChunkCounter<&ChunkCounts::patch_pairs>, std::uint64_t> patch_pairs;  ///< with one patch, or two
  ArrayList<ChunkCounter<&ChunkCounts::pairs>, std::uint64_t> pairs;
  ArrayList<ChunkCounter<&ChunkCounts::vt_candidates>, std::uint64_t> vt_candidates;
  ArrayList<ChunkCounter<&ChunkCounts::ee_candidates>, std::uint64_t> ee_candidates;

  /// Calls f with every list.
  template <class F>
  decltype(auto) with_all(const F& f) {
    // A list that is not named here, or not passed on, does not compile: it would never grow.
    const auto with = [&f](auto&... lists) -> decltype(auto) {
      static_assert((sizeof(lists) + ...) == sizeof(Lists));
      return f(lists...);
    };
    auto& [l0, l1, l2, l3, l4, l5, l6, l7, l8, l9, l10] = *this;
    return with(l0, l1, l2, l3, l4, l5, l6, l7, l8, l9, l10);
  }
};

/// Whether what a query's looks leave is of use to those after them, and by how much volumes should be grown for that.
/// Keeping pairs costs about a tenth of a look, and saves most of one.
class Usefulness {
 public:
  bool is_likely() const { return credit_ > 0; }
  float slack() const { return slack_; }

  /// Whether a look shall leave volumes to learn from: only now and then where those of many looks have taught nothing.
  bool wants_to_learn() { return lessons_in_vain_ < kMostInVain || ++looks_ % kSeldom == 0; }

  void confirm() {
    credit_ = kMostCredit;
    lessons_in_vain_ = 0;
  }
  void doubt() {
    if (credit_ == 0 || --credit_ > 0) return;
    slack_ = 0.0F;
    looks_to_rest_ = kRest;
  }

  /// From one look to the next no triangle moved further than this; `radius` is the mean triangle's.
  void learn(float move, float radius) {
    slack_ = 0.0F;
    ++lessons_in_vain_;
    if (looks_to_rest_ > 0) {
      --looks_to_rest_;
    } else if (move > 0.0F && kFewestLooks * move <= kMostSlack * radius) {
      slack_ = std::min(kLooks * move, kMostSlack * radius);
      credit_ = std::max(credit_, 1);
      lessons_in_vain_ = 0;
    }
  }

 private:
  static constexpr int kMostCredit = 6;
  static constexpr int kRest = 32;
  static constexpr int kMostInVain = 8;
  static constexpr int kSeldom = 16;
  /// How many looks volumes should last, and must for the pairs to pay.
  static constexpr float kLooks = 6.0F;
  static constexpr float kFewestLooks = 3.0F;
  /// In mean radii: more has more pairs to be tested than a look would save.
  static constexpr float kMostSlack = 0.4F;

  int credit_ = 0;
  int looks_to_rest_ = 0;
  int lessons_in_vain_ = 0;  ///< in a row
  int looks_ = 0;            ///< since they were too many
  float slack_ = 0.0F;
};

/// What one look leaves to those after it, of the same query and of others: the volumes of all triangles, grown by some
/// slack, and, where that is likely to be of use, all pairs of triangles whose volumes overlap. As long as each
/// triangle's volume lies within the one that is kept, the pairs that a look would find are among those.
template <class Backend>
struct KeptLook {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;

  Buffer<Kdop18> volumes;
  List<Backend, DetectionCounter<&Counters::kept>, ArrayTarget<std::uint64_t>, Buffer<std::uint64_t>> pairs;
  Buffer<KeptCounts> counts;
  Buffer<SceneBody> grown_bodies;  ///< with partner boxes that the slack has grown
  /// What was looked for, on the host; see SceneView.
  std::vector<SceneBody> bodies;
  std::vector<std::uint64_t> partner_begin;
  std::vector<std::uint32_t> partners;
  DetectionSettings settings{};
  std::uint64_t revision = 0;  ///< of the detector; 0: there is nothing
  float mean_radius = 0.0F;    ///< of its triangles
  bool has_pairs = false;
  float slack = 0.0F;
  int age = 0;                             ///< looks of the same query since
  std::shared_ptr<Usefulness> usefulness;  ///< of the looks of the query that has left it
  bool was_of_use = false;
  int misses = 0;  ///< looks since the last that it was of use to
  // Of the detector's last look that did not reuse pairs:
  bool has_looked = false;  ///< there was one
  bool has_split = false;   ///< some triangle: the next is likely to as well
};

/// What one launch does of a detection.
enum class LaunchPart : std::uint8_t {
  whole,
  comparison,  ///< of volumes with those that are kept
  remainder,   ///< after a comparison that has told to look anew
  reuse,       ///< after one that has told that pairs which are kept serve
};
constexpr std::size_t kLaunchPartCount = 4;

/// What a look does for others, beside finding its pairs.
struct KeepingWork {
  bool compares = false;  ///< volumes with those that are kept
  bool measures_headroom = false;
  bool keeps_volumes = false;  ///< grown by `slack`
  bool keeps_pairs = false;
  float slack = 0.0F;

  friend bool operator==(const KeepingWork&, const KeepingWork&) = default;
};

/// Everything that decides which work a launch enqueues, and with which arguments: of two launches with equal ones
/// the second enqueues the same work on the same memory.
struct Signature {
  LaunchPart part;
  KeepingWork keeping;
  std::uint64_t kept_capacity;  ///< of the list of kept pairs
  DetectionSettings settings;
  SceneView scene;
  SceneCounts counts;
  std::uint64_t chunks;
  bool orders_in_runs;
  std::uint32_t body_ids;               ///< see DeviceContacts
  const std::uint32_t* is_as_foreseen;  ///< see ForeseenVerdict
  std::array<std::uint64_t, kListCount> capacities;

  friend bool operator==(const Signature&, const Signature&) = default;
};

/// What a detection makes of a scene.
template <class Backend, class Scheme>
struct Workspace {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  template <class T>
  using SortBuffer = typename Backend::template SortBuffer<T>;

  Lists<Backend, Scheme> lists;
  KeptLook<Backend> kept;
  Buffer<Counters> counters;
  Buffer<std::uint32_t> size_bins;  ///< at most MeasurePatch::kHistograms histograms of kSizeBins

  // Per triangle:
  Buffer<Kdop18> volumes;
  Buffer<EndVolumes> end_volumes;
  Buffer<TriangleShape> shapes;
  // Per patch:
  Buffer<PatchBounds<false>> bounds_at_rest;
  Buffer<PatchBounds<true>> bounds_swept;
  // Per split triangle:
  Buffer<std::uint32_t> child_counts;
  Buffer<std::uint64_t> child_offsets;
  // and of ExactCells:
  Buffer<SplitBox> split_boxes;
  Buffer<std::uint32_t> word_counts;
  Buffer<std::uint64_t> word_offsets;
  Buffer<std::uint32_t> split_of;  ///< per triangle, where there are several ranks; see NumberSplit
  // Per entry:
  Buffer<BoxedEntry> boxed_entries;
  Buffer<std::uint32_t> partner_begin, partner_count;
  Buffer<std::uint64_t> test_offsets;
  // Per contact:
  SortBuffer<std::uint64_t> contact_keys;
  SortBuffer<std::uint32_t> contact_order;
  // Per run of contacts:
  Buffer<std::uint32_t> run_counts;
  Buffer<std::uint64_t> run_begins;

  /// Capacity for what is prepared of each entry.
  void reserve_entries(Backend& backend) {
    boxed_entries.reserve(backend, lists.entries.capacity(), 0);
    partner_begin.reserve(backend, lists.entries.capacity(), 0);
    partner_count.reserve(backend, lists.entries.capacity(), 0);
    test_offsets.reserve(backend, lists.entries.capacity(), 0);
  }
};

}  // namespace softcd

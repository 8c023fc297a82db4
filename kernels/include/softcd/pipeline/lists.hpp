#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <new>
#include <tuple>

#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/output.hpp"
#include "softcd/stages/cell_ranges.hpp"
#include "softcd/stages/contact_tests.hpp"
#include "softcd/stages/entry_bins.hpp"
#include "softcd/stages/grid_parameters.hpp"
#include "softcd/stages/split_cells.hpp"

/// The lists that stages append to, and their counters.
namespace softcd {

/// Counts of the lists between one chunk's tests and its contacts.
struct ChunkCounts {
  std::uint64_t patch_pairs, pairs, vt_candidates, ee_candidates;
};

/// Calls f for one count after the other, with that count of each of `counts`.
template <class F, class... Counts>
SOFTCD_HD void for_each_count(const F& f, Counts&... counts) {
  // A count that is not named here does not compile.
  [[maybe_unused]] const auto& [patch_pairs, pairs, vt_candidates, ee_candidates] = ChunkCounts{};
  f(counts.patch_pairs...);
  f(counts.pairs...);
  f(counts.vt_candidates...);
  f(counts.ee_candidates...);
}

/// Functions for for_each_count().
struct AddCount {
  SOFTCD_HD void operator()(std::uint64_t& sum, std::uint64_t count) const { sum += count; }
};
struct KeepLargerCount {
  SOFTCD_HD void operator()(std::uint64_t& most, std::uint64_t count) const { most = larger(most, count); }
};

/// Counts that a detection begins with.
struct SceneCounts {
  std::uint64_t triangles, vertex_triangle_neighbours, edge_edge_neighbours, stars;

  friend bool operator==(const SceneCounts&, const SceneCounts&) = default;
};

/// All counts of a detection, in the backend's memory; cleared at its beginning, read at its end.
struct Counters {
  SceneCounts scene;
  std::uint64_t loose, splits, bigs, children, split_cells, entries, cells, tests;
  std::uint64_t flagged, contacts, unsettled;
  std::uint64_t contacts_in_runs, long_runs;  ///< see contact_order.hpp
  std::uint64_t entries_in_bins, long_bins;   ///< see entry_bins.hpp
  std::uint64_t all;       ///< no less than anything whose number the host knows; 0: see ClearCounters
  ChunkCounts chunk;       ///< of the current one
  ChunkCounts done, most;  ///< of earlier chunks: the sum, and the largest
  float earliest_toi;
  GridParameters grid;
  std::uint64_t active, escaped;             ///< triangles, see FindEscaped
  float headroom;                            ///< 0, or the least that is less: see MeasureHeadroom
  std::uint64_t kept;                        ///< pairs that this detection keeps, or that the reused one kept
  std::uint64_t vt_contacts;                 ///< where contacts stay in the backend's memory
  std::uint32_t test_samples[kTestSamples];  ///< see TestSamples
};

/// Returns the memory of the largest chunk's lists. Pairs and candidates that were not counted yet are estimated as the
/// most that there can be.
inline std::uint64_t bytes_of_chunk(const Counters& reached, bool vertex_triangle, bool edge_edge) {
  ChunkCounts most = reached.chunk;
  for_each_count(KeepLargerCount{}, most, reached.most);
  if (most.pairs == 0) most.pairs = kPatchSize * kPatchSize * most.patch_pairs;
  if (most.vt_candidates == 0 && vertex_triangle) most.vt_candidates = 6 * most.pairs;
  if (most.ee_candidates == 0 && edge_edge) most.ee_candidates = 9 * most.pairs;
  return (most.patch_pairs + most.pairs + most.vt_candidates + most.ee_candidates) * sizeof(std::uint64_t);
}

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

/// Clears the counters. If positions are not as predicted, no work has an item.
struct ClearCounters {
  Counters* counters;
  SceneCounts scene;
  const std::uint32_t* is_as_predicted;  ///< see PredictionVerdict

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    if (!team.is_leader()) return;
    *counters = Counters{};
    counters->earliest_toi = 1.0F;
    if (is_as_predicted != nullptr && *is_as_predicted == 0) return;
    counters->scene = scene;
    counters->all = ~std::uint64_t{0};
  }
};

/// The number of values that a list was asked for, by this chunk and by any earlier one, and its capacity.
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

/// Stages number items with 32 bits. A list that would be longer counts as out of memory: its values have to be found
/// in parts.
constexpr std::uint64_t kMostItems = 0xFFFFFFFF;

/// A growing list and its counter. `Columns` are the buffers behind it, all of one capacity.
template <class Backend, class Counter, class Target, class... Columns>
class List {
 public:
  /// Whether it holds values between one chunk's tests and its contacts.
  static constexpr bool kIsOfChunk = Counter::kIsOfChunk;

  /// The number of values that were asked for.
  static std::uint64_t& counted(Counters& counters) { return Counter::in(counters); }
  static std::uint64_t counted(const Counters& counters) { return Counter::in(counters); }

  /// The number of values that the next stage may store.
  std::uint64_t capacity() const { return bound_; }
  /// Restores the capacity after another detection, as far as there is memory for it.
  void restore_capacity(std::uint64_t capacity) { bound_ = std::min(capacity, allocated_); }

  /// Keeps the first `kept` values. Reserves a quarter more than `wanted`, so that slowly growing scenes seldom grow a
  /// list, but only `wanted` if memory does not suffice.
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

  /// Reserves no more than `wanted`, for when memory is short. The values are lost.
  void reserve_only(Backend& backend, std::uint64_t wanted) {
    if (wanted <= bound_) return;
    if (wanted > kMostItems) throw std::bad_alloc();
    bound_ = allocated_ = 0;  // until all columns have grown
    reserve_columns(backend, wanted, 0);
    bound_ = allocated_ = wanted;
  }

  /// Lowers the capacity to that of a detection that counted `count` values. Work whose size the host does not know is
  /// sized by the capacity.
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

constexpr std::size_t kListCount = 11;

/// The lists that stages append to. `Scheme` is one like ExactScheme.
template <class Backend, class Scheme>
struct Lists {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  template <class T>
  using SortBuffer = typename Backend::template SortBuffer<T>;
  template <class Counter, class T>
  using ArrayList = List<Backend, Counter, ArrayTarget<T>, Buffer<T>>;

  // Lists of the whole detection, in the order in which they grow. They come first, because chunks cannot make them
  // smaller if memory is short.
  ArrayList<DetectionCounter<&Counters::bigs>, std::uint32_t> bigs;
  ArrayList<DetectionCounter<&Counters::loose>, std::uint32_t> loose;  ///< triangles of loose patches
  ArrayList<DetectionCounter<&Counters::splits>, typename Scheme::Split> splits;
  typename Scheme::template SplitCells<Backend> split_cells;
  List<Backend, DetectionCounter<&Counters::entries>, EntryTarget, SortBuffer<std::uint32_t>, SortBuffer<Entry>>
      entries;
  List<Backend, DetectionCounter<&Counters::flagged>, ArrayTarget<std::uint64_t>, SortBuffer<std::uint64_t>> flagged;
  ArrayList<DetectionCounter<&Counters::contacts>, FeatureContact> found;
  // Lists of one chunk.
  ArrayList<ChunkCounter<&ChunkCounts::patch_pairs>, std::uint64_t> patch_pairs;  ///< with one patch, or two
  ArrayList<ChunkCounter<&ChunkCounts::pairs>, std::uint64_t> pairs;
  ArrayList<ChunkCounter<&ChunkCounts::vt_candidates>, std::uint64_t> vt_candidates;
  ArrayList<ChunkCounter<&ChunkCounts::ee_candidates>, std::uint64_t> ee_candidates;

  /// Calls f with every list.
  template <class F>
  decltype(auto) with_all(const F& f) {
    // A list that is not named here, or not passed on, would never grow. So it does not compile.
    const auto with = [&f](auto&... lists) -> decltype(auto) {
      static_assert((sizeof(lists) + ...) == sizeof(Lists));
      return f(lists...);
    };
    auto& [l0, l1, l2, l3, l4, l5, l6, l7, l8, l9, l10] = *this;
    return with(l0, l1, l2, l3, l4, l5, l6, l7, l8, l9, l10);
  }
};

}  // namespace softcd

#pragma once

#include <algorithm>
#include <cstdint>
#include <new>
#include <tuple>

#include "softcd/pipeline/output.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/cell_ranges.hpp"
#include "softcd/stages/contact_output.hpp"
#include "softcd/stages/grid_parameters.hpp"
#include "softcd/stages/split_cells.hpp"

namespace softcd {

/// Counts of the lists that hold what comes between one chunk's tests and its contacts.
struct ChunkCounts {
  std::uint64_t pairs, vt_candidates, ee_candidates;
};

/// Counts that a detection begins with.
struct SceneCounts {
  std::uint64_t triangles, vertex_triangle_neighbours, edge_edge_neighbours;
};

/// Everything that is counted during a detection, in the backend's memory; cleared at its beginning, read at its end.
struct Counters {
  SceneCounts scene;
  std::uint64_t splits, bigs, children, split_words, split_cells, entries, cells, tests;
  std::uint64_t flagged, pairs;
  std::uint64_t vt_candidates, ee_candidates, contacts, unsettled;
  ChunkCounts done, most;  ///< of the chunks before the current one: together, and in one
  float earliest_toi;
  GridParameters grid;
};

/// Begins the next chunk.
struct NextChunk {
  Counters* counters;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    if (!team.is_leader()) return;
    next(counters->pairs, counters->done.pairs, counters->most.pairs);
    next(counters->vt_candidates, counters->done.vt_candidates, counters->most.vt_candidates);
    next(counters->ee_candidates, counters->done.ee_candidates, counters->most.ee_candidates);
  }

 private:
  static SOFTCD_HD void next(std::uint64_t& count, std::uint64_t& done, std::uint64_t& most) {
    done += count;
    most = larger(most, count);
    count = 0;
  }
};

struct ClearCounters {
  Counters* counters;
  SceneCounts scene;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    if (!team.is_leader()) return;
    *counters = Counters{};
    counters->scene = scene;
    counters->earliest_toi = 1.0F;
  }
};

/// A growing list and its counter. `Columns` are the buffers behind it, all of one capacity.
template <class Backend, class Target, class... Columns>
class List {
 public:
  using Counter = std::uint64_t Counters::*;

  explicit List(Counter counter) : counter_(counter) {}

  Counter counter() const { return counter_; }

  /// How many values the next stage may store.
  std::uint64_t capacity() const { return bound_; }

  /// Keeps the first `kept` values. There will be room for a quarter more than asked for, so that slowly growing scenes
  /// seldom grow a list; for no more than that where memory does not suffice.
  void reserve(Backend& backend, std::uint64_t wanted, std::uint64_t kept) {
    if (wanted <= bound_) return;
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
    return {std::apply([](auto&... column) { return Target{column.data()...}; }, columns_), &(counters->*counter_),
            bound_};
  }
  Count count(const Counters* counters) const { return {&(counters->*counter_), bound_}; }

 private:
  void reserve_columns(Backend& backend, std::uint64_t bound, std::uint64_t kept) {
    std::apply([&](auto&... column) { (column.reserve(backend, bound, kept), ...); }, columns_);
  }

  /// A quarter more, rounded up to an eighth of an octave, so that it stays the same while counts change little.
  static std::uint64_t roomy(std::uint64_t count) {
    const std::uint64_t wanted = count == 0 ? 0 : count + count / 4 + 256;
    std::uint64_t step = 1;
    while (step * 16 <= wanted) step *= 2;
    return (wanted + step - 1) / step * step;
  }

  Counter counter_;
  std::uint64_t allocated_ = 0;
  std::uint64_t bound_ = 0;
  std::tuple<Columns...> columns_;
};

/// The scene that the lists of a Workspace are about. Vertices, triangles and bodies as SceneView describes them.
template <class Backend>
struct SceneMemory {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;

  Buffer<Vec3f> x_t0, x_t1;
  Buffer<Triangle> triangles, triangle_edges;
  Buffer<Edge> edges;
  Buffer<Ownership> ownership;
  Buffer<std::uint32_t> triangle_body, vertex_body;
  Buffer<std::uint64_t> vertex_triangle_neighbours, edge_edge_neighbours;
  Buffer<SceneBody> bodies;
  Buffer<std::uint64_t> partner_begin;
  Buffer<std::uint32_t> partners;
};

/// What a detection makes of it.
template <class Backend>
struct Workspace {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  template <class T>
  using SortBuffer = typename Backend::template SortBuffer<T>;
  template <class T>
  using ArrayList = List<Backend, ArrayTarget<T>, Buffer<T>>;

  Buffer<Counters> counters;
  Buffer<std::uint32_t> size_bins;  ///< MeasureTriangle::kHistograms histograms of kSizeBins

  // Broad phase. Per triangle:
  Buffer<Kdop18> volumes;
  Buffer<EndVolumes> end_volumes;
  Buffer<TriangleShape> shapes;
  ArrayList<std::uint32_t> bigs{&Counters::bigs};
  ArrayList<SplitRoot> splits{&Counters::splits};
  Buffer<std::uint32_t> split_of_triangle;  ///< `paper` only
  // Per split triangle:
  Buffer<std::uint32_t> child_counts;
  Buffer<std::uint64_t> child_offsets;
  // and in `exact`:
  Buffer<SplitBox> split_boxes;
  Buffer<std::uint32_t> word_counts;
  Buffer<std::uint64_t> word_offsets;
  ArrayList<std::uint32_t> split_words{&Counters::split_words};
  // or in `paper`:
  List<Backend, SplitCellTarget, SortBuffer<std::uint64_t>, SortBuffer<std::uint32_t>> split_cells{
      &Counters::split_cells};
  // Per entry:
  List<Backend, EntryTarget, SortBuffer<std::uint32_t>, SortBuffer<Entry>> entries{&Counters::entries};
  Buffer<BoxedEntry> boxed_entries;
  Buffer<std::uint32_t> partner_begin, partner_count;
  Buffer<std::uint64_t> test_offsets;
  List<Backend, ArrayTarget<std::uint64_t>, SortBuffer<std::uint64_t>> flagged{&Counters::flagged};
  ArrayList<std::uint64_t> pairs{&Counters::pairs};

  // Narrow phase.
  ArrayList<std::uint64_t> vt_candidates{&Counters::vt_candidates};
  ArrayList<std::uint64_t> ee_candidates{&Counters::ee_candidates};
  ArrayList<FeatureContact> found{&Counters::contacts};
  SortBuffer<std::uint64_t> contact_keys;
  SortBuffer<std::uint32_t> contact_order;
  Buffer<Contact> contacts;

  void reserve_sorted_contacts(Backend& backend, std::uint64_t count) {
    contacts.reserve(backend, count, 0);
    contact_keys.reserve(backend, count, 0);
    contact_order.reserve(backend, count, 0);
  }
};

}  // namespace softcd

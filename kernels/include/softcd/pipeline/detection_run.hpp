#pragma once

#include <algorithm>
#include <cstdint>
#include <new>
#include <utility>

#include "softcd/pipeline/detection_stages.hpp"

namespace softcd {

/// One detection, from its start to its contacts. Runs its stages again with longer lists, or with less memory, until
/// all contacts are found.
template <class Backend, class Scheme>
class DetectionRun {
  /// Memory of one contact: as found, as given to the user, and twice its key and place, which are sorted.
  static constexpr std::uint64_t kBytesOfContact =
      sizeof(FeatureContact) + sizeof(Contact) + 2 * (sizeof(std::uint64_t) + sizeof(std::uint32_t));

 public:
  /// The scene's view is that of the detection. `revision` is the detector's.
  DetectionRun(DetectorMemory<Backend, Scheme>& memory, QueryOn<Backend>& query, const SceneBodies& bodies,
               const DetectionSettings& settings, std::uint64_t revision)
      : memory_(memory),
        query_(query),
        settings_(settings),
        revision_(revision),
        stages_(memory, query, bodies, settings, revision) {
    query_.orders_in_runs |= query_.revision != revision_;
    query_.lays_into_bins |= query_.revision != revision_;
  }

  void start() {
    restore_capacities();
    guess_lists();
    is_launched_ = attempt([&] { stages_.launch(); });
  }

  StayingContacts staying() const { return stages_.staying(); }

  /// Waits for the contacts, and repeats the detection until they are complete. See Detector::finish().
  Span<const Contact> finish(Statistics& statistics) {
    Counters counters{};
    bool is_complete = false;
    while (!is_complete) {
      attempt([&] {
        if (!std::exchange(is_launched_, false)) stages_.launch();
        counters = read_counters();
        is_complete = fits(counters);
        if (is_complete) return;
        stages_.keep_nothing();
        memory_.backend.count_rerun();
      });
    }
    stages_.conclude(counters);
    if (counters.all == 0) {  // nothing was detected
      memory_.backend.contacts(0);
      statistics.ms = memory_.backend.times();
      return {};
    }
    lists().with_all([&](auto&... lists) {
      if (!Backend::kKnowsCounts && !stages_.has_reused()) fit_lists(counters, lists...);
      query_.capacities = {lists.capacity()...};
    });
    query_.chunks = chunks();
    query_.revision = revision_;
    const Span<const Contact> contacts = memory_.backend.contacts(counters.contacts);
    report(counters, contacts, statistics);
    samples_.tests = counters.tests;
    std::copy(std::begin(counters.test_samples), std::end(counters.test_samples), samples_.cells);
    return contacts;
  }

  /// Returns samples of the tests, once the detection is finished.
  const TestSamples& test_samples() const { return samples_; }
  std::uint64_t chunks() const { return stages_.chunks().count(); }
  /// Returns the number of contacts that had been found when memory ran out.
  std::uint64_t found() const { return found_; }
  /// Returns whether contacts take most of `bytes`.
  bool is_full_of_contacts(std::uint64_t bytes) const { return found_ * kBytesOfContact > bytes / 2; }

 private:
  Lists<Backend, Scheme>& lists() { return memory_.workspace.lists; }

  /// All queries share the lists, but need different capacities.
  void restore_capacities() {
    lists().with_all([&](auto&... lists) {
      std::size_t i = 0;
      (lists.restore_capacity(query_.capacities[i++]), ...);
    });
  }

  /// Guesses first capacities, so that an ordinary first detection need not repeat a stage. Guesses nothing if memory
  /// is limited or does not suffice. Small scenes get much, as it takes little memory. Large scenes get what a cloth on
  /// a ball needs, because memory that a first detection takes is kept. A scene that needs more repeats a stage once.
  void guess_lists() {
    constexpr std::uint64_t kOrdinaryScene = 1ULL << 18;
    const std::uint64_t triangles = memory_.scene.view().triangle_count / settings_.partition.rank.count;
    if (query_.guessed_for == triangles || memory_.account->is_limited()) return;
    query_.guessed_for = triangles;
    const std::uint64_t first = std::min(triangles, kOrdinaryScene);
    const std::uint64_t rest = triangles - first;
    const bool has_patches = puts_patches_into_cells<Backend, Scheme>(settings_);
    Lists<Backend, Scheme>& lists = this->lists();
    Backend& backend = memory_.backend;
    try {
      lists.entries.reserve(backend, (6 * first + 4 * rest) / (has_patches ? 4 : 1), 0);
      if (has_patches) {
        lists.loose.reserve(backend, triangles / 4, 0);
        lists.patch_pairs.reserve(backend, 5 * first + 2 * rest, 0);
      }
      lists.pairs.reserve(backend, 8 * first + 3 * rest, 0);
      if (settings_.vertex_triangle) lists.vt_candidates.reserve(backend, 8 * first + rest, 0);
      if (settings_.edge_edge) lists.ee_candidates.reserve(backend, 16 * first + 2 * rest, 0);
      lists.found.reserve(backend, 4 * first + rest, 0);
    } catch (const std::bad_alloc&) {
      memory_.release_lists();
    }
  }

  /// Runs f and returns whether it succeeds. If memory runs out, prepares another attempt. Throws std::bad_alloc if no
  /// further attempt can succeed.
  template <class F>
  bool attempt(const F& f) {
    try {
      f();
      return true;
    } catch (const std::bad_alloc&) {
    }
    try {
      make_room();
    } catch (const std::bad_alloc&) {
      memory_.release_lists();
      query_.contacts = {};
      throw;
    }
    memory_.backend.count_rerun();
    return false;
  }

  /// Releases all lists. Then reserves what is known to be needed for contacts, and for other lists that more chunks
  /// cannot make smaller. Divides the detection into so many chunks that the lists of one should fit into half of the
  /// remaining memory. Throws std::bad_alloc if that cannot help.
  void make_room() {
    stages_.forget_kept();
    const Counters reached = counters_reached();
    found_ = reached.contacts;
    memory_.release_lists();
    query_.contacts = {};
    const std::uint64_t chunk_bytes = bytes_of_chunk(reached, settings_.vertex_triangle, settings_.edge_edge);
    if (chunk_bytes == 0 && std::exchange(has_released_, true)) throw std::bad_alloc();
    lists().with_all([&](auto&... lists) { (reserve_whole(lists, reached), ...); });
    stages_.reserve_sorted_contacts(reached.contacts);
    if (chunk_bytes == 0) return;
    const MemoryAccount& account = *memory_.account;
    const std::uint64_t remaining = account.available() - std::min(account.available(), account.bytes());
    stages_.chunks().divide(chunk_bytes, remaining / 2, /*begins_there=*/Backend::kKnowsCounts);
  }

  /// Reserves a list of the whole detection, with nothing to spare. Leaves the list of a chunk alone.
  template <class List>
  void reserve_whole(List& list, const Counters& reached) {
    if constexpr (!List::kIsOfChunk) list.reserve_only(memory_.backend, list.counted(reached));
  }

  /// Returns the counters of the failed attempt, as far as they are known. For lists that overflowed they include what
  /// did not fit.
  Counters counters_reached() {
    if constexpr (Backend::kKnowsCounts) {
      const auto& counters = memory_.workspace.counters;
      if (counters.capacity() > 0) return *counters.data();
    }
    return reached_;
  }

  /// Waits for the counters. Replaces the counts of the last chunk by the largest ones of any chunk.
  Counters read_counters() {
    Counters counters = memory_.backend.finish();
    query_.total = counters.done;
    for_each_count(AddCount{}, query_.total, counters.chunk);
    for_each_count(KeepLargerCount{}, counters.chunk, counters.most);
    reached_ = counters;
    return counters;
  }

  /// Returns whether all lists were long enough. Grows those that were not, and gives up orders that had too little
  /// space.
  bool fits(const Counters& counters) {
    bool fits = !lists().with_all([&](auto&... lists) { return grow_lists(memory_.backend, counters, lists...); });
    if (stages_.grow_kept_pairs(counters)) fits = false;
    const bool has_long_runs = query_.orders_in_runs && counters.long_runs > 0;
    if (has_long_runs) query_.orders_in_runs = false;
    if (!Backend::kKnowsCounts && has_long_runs) fits = false;
    if (counters.long_bins > 0) fits = query_.lays_into_bins = false;
    return fits;
  }

  /// Counts vertex-triangle contacts, which come first.
  static std::uint64_t vertex_triangle_count(Span<const Contact> contacts) {
    const auto* end = std::partition_point(contacts.begin(), contacts.end(), [](const Contact& contact) {
      return contact.kind == ContactKind::vertex_triangle;
    });
    return static_cast<std::uint64_t>(end - contacts.begin());
  }

  void report(const Counters& counters, Span<const Contact> contacts, Statistics& statistics) const {
    statistics.active_triangles = counters.grid.active_triangles;
    statistics.mean_radius = static_cast<double>(counters.grid.mean_radius);
    statistics.cell_size = static_cast<double>(counters.grid.cell_size);
    statistics.split_triangles = counters.splits;
    statistics.children = counters.children;
    statistics.big_triangles = counters.bigs;
    statistics.entries = counters.entries;
    statistics.cells = counters.cells;
    statistics.tests =
        stages_.has_reused() ? counters.kept : counters.tests + counters.bigs * counters.grid.active_elements;
    statistics.reused_pairs = stages_.has_reused();
    statistics.looked_up_triangles = stages_.has_reused() ? counters.escaped : 0;
    statistics.triangle_pairs = query_.total.pairs;
    statistics.flagged_pairs = counters.flagged;
    statistics.vt_candidates = query_.total.vt_candidates;
    statistics.ee_candidates = query_.total.ee_candidates;
    statistics.vt_contacts = settings_.contacts_stay ? counters.vt_contacts : vertex_triangle_count(contacts);
    statistics.ee_contacts = contacts.size() - statistics.vt_contacts;
    statistics.unsettled_contacts = counters.unsettled;
    statistics.earliest_toi = static_cast<double>(counters.earliest_toi);
    statistics.ms = memory_.backend.times();
  }

  DetectorMemory<Backend, Scheme>& memory_;
  QueryOn<Backend>& query_;
  const DetectionSettings settings_;
  const std::uint64_t revision_;
  DetectionStages<Backend, Scheme> stages_;
  bool is_launched_ = false;
  bool has_released_ = false;  ///< the lists have only what this detection needs itself
  Counters reached_{};         ///< of the last attempt that was finished; 0 at the start
  std::uint64_t found_ = 0;    ///< contacts, when memory ran out
  TestSamples samples_;
};

}  // namespace softcd

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "softcd/pipeline/kept_results.hpp"
#include "softcd/stages/patches.hpp"
#include "softcd/stages/split_cells.hpp"

namespace softcd {

/// The part of a detection that one launch does.
enum class LaunchPart : std::uint8_t {
  whole,
  comparison,  ///< of volumes with the kept ones
  remainder,   ///< after a comparison: searches all pairs
  reuse,       ///< after a comparison: reuses the kept pairs
};
constexpr std::size_t kLaunchPartCount = 4;

/// Everything that decides which work a launch enqueues, and with which arguments. Of two launches with equal
/// signatures the second enqueues the same work on the same memory.
struct Signature {
  LaunchPart part;
  KeepingWork keeping;
  std::uint32_t kept_number;    ///< see Workspace
  std::uint64_t kept_capacity;  ///< of the list of kept pairs
  DetectionSettings settings;
  SceneView scene;
  SceneCounts counts;
  std::uint64_t chunks;
  bool orders_in_runs;
  bool lays_into_bins;
  std::uint32_t body_ids;                ///< see DeviceContacts
  const std::uint32_t* is_as_predicted;  ///< see PredictionVerdict
  std::array<std::uint64_t, kListCount> capacities;

  friend bool operator==(const Signature&, const Signature&) = default;
};

/// Everything that a detection computes from a scene.
template <class Backend, class Scheme>
struct Workspace {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  template <class T>
  using SortBuffer = typename Backend::template SortBuffer<T>;

  Lists<Backend, Scheme> lists;
  std::array<KeptPairs<Backend>, kMostKept> kept_results;
  std::uint32_t kept_number = 0;  ///< the place in kept_results that the present detection uses
  std::uint64_t kept_count = 0;   ///< the number of results that were kept so far
  bool has_detected = false;      ///< the detector had a detection that did not reuse pairs
  bool has_split = false;         ///< the last of these split a triangle: the next is likely to, too
  Buffer<Counters> counters;
  Buffer<std::uint32_t> size_bins;  ///< at most MeasurePatch::kHistograms histograms of kSizeBins

  // Per triangle:
  Buffer<Kdop18> volumes;
  Buffer<EndVolumes> end_volumes;
  Buffer<TriangleShape> shapes;
  Buffer<SlabReach> slabs;  ///< where contacts are those of ContactRule::slab
  // Bytes per vertex, triangle and edge; see SpreadParts:
  Buffer<std::uint8_t> spread_vertices, spread_triangles, spread_edges;
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
  // Per bin of entries:
  bool lays_into_bins = false;  ///< instead of sorting entries; see entry_bins.hpp
  Buffer<std::uint32_t> bin_counts;
  Buffer<std::uint64_t> bin_begins;
  // Per contact:
  SortBuffer<std::uint64_t> contact_keys;
  SortBuffer<std::uint32_t> contact_order;
  // Per run of contacts:
  Buffer<std::uint32_t> run_counts;
  Buffer<std::uint64_t> run_begins;

  /// Returns the results that the present detection compares with, or keeps.
  KeptPairs<Backend>& kept() { return kept_results[kept_number]; }

  EntryBins bins() const { return plan_bins(lists.entries.capacity()); }

  /// Returns the list of entries for stages that append to it.
  auto entry_appender() {
    if constexpr (Backend::kKnowsCounts) {
      return lists.entries.appender(counters.data());
    } else {
      const auto [target, count, capacity] = lists.entries.appender(counters.data());
      return Appender<BinTarget>{{target, bins(), lays_into_bins ? bin_counts.data() : nullptr, partner_begin.data(),
                                  &counters.data()->long_bins},
                                 count,
                                 capacity};
    }
  }

  /// Reserves capacity for the values of each entry.
  void reserve_entries(Backend& backend) {
    boxed_entries.reserve(backend, lists.entries.capacity(), 0);
    partner_begin.reserve(backend, lists.entries.capacity(), 0);
    partner_count.reserve(backend, lists.entries.capacity(), 0);
    test_offsets.reserve(backend, lists.entries.capacity(), 0);
  }
};

}  // namespace softcd

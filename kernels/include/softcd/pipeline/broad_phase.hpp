#pragma once

#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/exact_cells.hpp"
#include "softcd/pipeline/produce.hpp"
#include "softcd/pipeline/stage_clock.hpp"
#include "softcd/pipeline/workspace.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/cell_ranges.hpp"
#include "softcd/stages/clear_word.hpp"
#include "softcd/stages/entry_bins.hpp"
#include "softcd/stages/grid_parameters.hpp"
#include "softcd/stages/kept_pairs.hpp"
#include "softcd/stages/pair_tests.hpp"
#include "softcd/stages/patches.hpp"
#include "softcd/stages/shared_pairs.hpp"

/// The broad phase's stage order, once for all backends: triangles in, triangle pairs out.
namespace softcd {

constexpr int kEntryKeyBits = kCellBits + 3;

constexpr int bits_for(std::uint64_t count) {
  int bits = 0;
  while (bits < 64 && (count >> bits) != 0) ++bits;
  return bits;
}

/// `Scheme`, such as ExactScheme, says how triangles get their cells, and in which of them a pair is tested.
template <class Backend, class Scheme>
class BroadPhaseStages {
 public:
  BroadPhaseStages(Backend& backend, Workspace<Backend, Scheme>& workspace, const SceneView& scene,
                   const DetectionSettings& settings)
      : backend_(backend),
        w_(workspace),
        lists_(workspace.lists),
        counters_(workspace.counters.data()),
        scene_(scene),
        settings_(settings) {}

  /// Bounds triangles, and empties the bins of entries if entries are laid into bins. Also measures the triangles if
  /// kMeasuresAtOnce, and their slabs if these reject pairs.
  void bound_triangles() {
    if (!w_.lays_into_bins) return bound_all();
    w_.reserve_entries(backend_);
    w_.bin_counts.reserve(backend_, w_.bins().count(), 0);
    w_.bin_begins.reserve(backend_, w_.bins().count(), 0);
    const auto clear = [&] { backend_.for_each("clear_bins", bins(), ClearWord{w_.bin_counts.data()}); };
    backend_.concurrently([&] { bound_all(); }, clear);
  }
  /// Bounds triangles as if the scene's bodies were those of `scene`.
  void bound_triangles(const SceneView& scene) {
    backend_.for_each("bound_triangles", triangles(), triangle_bounder(scene));
  }

  /// The wanted pairs: all with overlapping volumes, or only those that may meet where their triangles are at both ends
  /// of the step.
  enum class Wanted { overlapping_volumes, meeting_triangles };
  /// Does everything before the pair tests. The triangles must be bounded. If their volumes have changed since then,
  /// measures them again.
  void prepare(Wanted wanted, bool have_changed) {
    const bool compares_ends = scene_.is_swept && wanted == Wanted::meeting_triangles;
    prepare_grid(compares_ends, !kMeasuresAtOnce || have_changed);
  }

  /// Tests a share of the pairs that meet in cells.
  void test_pairs(Share share) {
    if (scene_.is_swept) {
      test_share(share, pair_test<true>(), lists_.pairs);
    } else {
      test_share(share, pair_test<false>(), lists_.pairs);
    }
  }

  /// Expands pairs with patches into pairs of triangles: once for each chunk, when all its pairs with patches are
  /// found.
  void expand_patch_pairs() {
    if (scene_.is_swept) {
      expand_patch_pairs<true>(lists_.pairs);
    } else {
      expand_patch_pairs<false>(lists_.pairs);
    }
  }

  /// Adds the pairs that had to be made unique, and those with the BIG list. All shares must be tested.
  void add_remaining_pairs() {
    if (scene_.is_swept) {
      add_remaining(pair_test<true>(), lists_.pairs);
    } else {
      add_remaining(pair_test<false>(), lists_.pairs);
    }
  }

  /// Finds the triangles that are not within the kept volumes. Lists no more than kMostEscaped.
  void find_escaped() {
    w_.kept().escaped.reserve(backend_, kMostEscaped, 0);
    w_.kept().escaped_groups.reserve(backend_, kMostEscaped / kEscapedGroup, 0);
    backend_.for_each_append(
        "find_escaped", triangles(), FindEscaped{w_.volumes.data(), w_.kept().volumes.data(), w_.shapes.data()},
        Appender<CountTarget>{{}, &counters_->active, 0},
        Appender<ArrayTarget<std::uint32_t>>{{w_.kept().escaped.data()}, &counters_->escaped, kMostEscaped});
  }

  /// Lowers the counters' headroom to the least of all triangles.
  void measure_headroom() {
    backend_.minimum("measure_headroom", triangles(), MeasureHeadroom{w_.volumes.data(), w_.kept().volumes.data()},
                     &counters_->headroom);
  }

  void keep_volumes(float slack) {
    w_.kept().volumes.reserve(backend_, scene_.element_count(), 0);
    backend_.for_each("keep_volumes", triangles(), KeepVolume{w_.volumes.data(), w_.kept().volumes.data(), slack});
  }

  /// Keeps all pairs whose volumes overlap, wherever in these the triangles are. Finds this detection's pairs among
  /// them, by the `present` volumes. prepare() must have run.
  void keep_pairs(const Kdop18* present) {
    test_share({0, 1}, pair_test<false>(w_.volumes.data(), nullptr), w_.kept().pairs);
    add_remaining(pair_test<false>(w_.volumes.data(), nullptr), w_.kept().pairs);
    test_kept_pairs(present, 0U);
    if constexpr (kMayHavePatches) {
      if (scene_.patch_count > 0) keep_patch_pairs(present);
    }
  }

  /// Finds the pairs among the kept ones, but for those of escaped triangles.
  void test_kept_pairs() {
    const bool has_none = Backend::kKnowsCounts && counters_->escaped == 0;
    test_kept_pairs(w_.volumes.data(), has_none ? 0U : kEscapedTriangle);
  }

  /// Finds the pairs of escaped triangles. There must be no more than kMostEscaped.
  void look_up_escaped() {
    if (scene_.is_swept) {
      look_up_escaped<true>();
    } else {
      look_up_escaped<false>();
    }
  }

 private:
  static constexpr bool kMayHavePatches = Backend::kHasPatches && Scheme::kMayHavePatches;

  using Control = typename Scheme::Control;
  using Cells = typename Scheme::template Cells<Backend>;

  /// Whether one stage bounds and measures triangles. Others bound patches in between.
  static constexpr bool kMeasuresAtOnce = !Backend::kHasPatches;

  Cells cells() { return {backend_, w_, scene_, settings_}; }

  BoundTriangle triangle_bounder(const SceneView& scene) {
    backend_.begin(Stage::volumes);
    w_.volumes.reserve(backend_, scene_.element_count(), 0);
    w_.shapes.reserve(backend_, scene_.element_count(), 0);
    if (scene_.is_swept) w_.end_volumes.reserve(backend_, scene_.element_count(), 0);
    return {scene, w_.volumes.data(), w_.end_volumes.data(), w_.shapes.data()};
  }

  void reserve_size_bins() { w_.size_bins.reserve(backend_, MeasurePatch::kHistograms * kSizeBins, 0); }

  void bound_all() {
    bound_and_measure();
    if (!scene_.has_certain_slabs()) return;
    w_.slabs.reserve(backend_, scene_.triangle_count, 0);
    backend_.for_each("measure_slabs", triangles(), MeasureSlab{scene_, w_.volumes.data(), w_.slabs.data()});
  }

  void bound_and_measure() {
    if constexpr (kMeasuresAtOnce) {
      const BoundTriangle bound_triangle = triangle_bounder(scene_);
      reserve_size_bins();
      backend_.histogram("bound_and_measure_triangles", triangles(), w_.size_bins.data(), MeasureTriangle::kHistograms,
                         kSizeBins, BoundAndMeasure{bound_triangle, {w_.volumes.data(), w_.shapes.data()}});
    } else {
      bound_triangles(scene_);
    }
  }

  void prepare_grid(bool compares_ends, bool measures) {
    if constexpr (kMayHavePatches) {
      if (scene_.patch_count > 0) bound_patches(compares_ends);
    }
    const SizeHistograms sizes = measure(measures);
    Cells cells = this->cells();
    backend_.run_once("choose_grid", cells.choose_grid(sizes));
    backend_.begin(Stage::assignment);
    cells.register_triangles();
    if (cells.subdivides() && lists_.splits.capacity() > 0) {
      backend_.begin(Stage::subdivision);
      count_children();
      cells.register_children(lists_.splits.count(counters_));
    }
    backend_.begin(Stage::sort);
    if (compares_ends) {
      order_entries<true>();
    } else {
      order_entries<false>();
    }
  }

  void bound_patches(bool compares_ends) {
    if (compares_ends) {
      bound_patches<true>(w_.end_volumes.data());
    } else {
      bound_patches<false>(nullptr);
    }
  }

  template <bool kSwept>
  void bound_patches(EndVolumes* end_volumes) {
    auto& bounds = patch_bounds<kSwept>();
    bounds.reserve(backend_, scene_.patch_count, 0);
    backend_.for_each("bound_patches", patches(),
                      BoundPatch<kSwept>{scene_, w_.volumes.data(), end_volumes, w_.shapes.data(), bounds.data()});
  }

  template <bool kSwept>
  auto& patch_bounds() {
    if constexpr (kSwept) {
      return w_.bounds_swept;
    } else {
      return w_.bounds_at_rest;
    }
  }

  SizeHistograms measure(bool measures) {
    reserve_size_bins();
    std::uint32_t* const bins = w_.size_bins.data();
    const MeasureTriangle measure_triangle{w_.volumes.data(), w_.shapes.data()};
    bool has_measured = false;
    if constexpr (kMayHavePatches) has_measured = measure_patches({scene_, measure_triangle});
    if (measures && !has_measured) {
      backend_.histogram("measure_triangles", triangles(), bins, MeasureTriangle::kHistograms, kSizeBins,
                         measure_triangle);
    }
    const int triangle_radius = has_measured ? +MeasurePatch::triangle_radius : +MeasureTriangle::at_rest;
    return {bins + MeasureTriangle::at_rest * kSizeBins, bins + MeasureTriangle::swept * kSizeBins,
            bins + MeasureTriangle::extent * kSizeBins, bins + MeasureTriangle::distance * kSizeBins,
            bins + triangle_radius * kSizeBins};
  }

  /// Returns whether there are patches.
  bool measure_patches(const MeasurePatch& measure_patch) {
    if (scene_.patch_count == 0) return false;
    backend_.histogram("measure_patches", patches(), w_.size_bins.data(), MeasurePatch::kHistograms, kSizeBins,
                       measure_patch);
    return true;
  }

  void count_children() {
    const Count splits = lists_.splits.count(counters_);
    w_.child_counts.reserve(backend_, lists_.splits.capacity(), 0);
    w_.child_offsets.reserve(backend_, lists_.splits.capacity(), 0);
    backend_.for_each(
        "count_children", splits,
        CountChildren<typename Scheme::Split>{lists_.splits.template column<0>().data(), w_.child_counts.data()});
    backend_.exclusive_scan("scan_children", splits, w_.child_counts.data(), w_.child_offsets.data(),
                            &counters_->children);
  }

  template <bool kSwept>
  PrepareEntry<Control, kSwept> prepare_entry(const std::uint32_t* keys, const Entry* entries) {
    return {scene_,
            w_.volumes.data(),
            kSwept ? w_.end_volumes.data() : nullptr,
            &counters_->grid,
            keys,
            entries,
            w_.boxed_entries.data(),
            w_.partner_begin.data(),
            w_.partner_count.data()};
  }

  template <bool kSwept>
  void sort_entries() {
    auto& keys = lists_.entries.template column<0>();
    auto& entries = lists_.entries.template column<1>();
    backend_.sort_pairs("sort_entries", lists_.entries.count(counters_), keys, entries, kEntryKeyBits);
    w_.reserve_entries(backend_);
    backend_.for_each_append("prepare_entries", lists_.entries.count(counters_),
                             prepare_entry<kSwept>(keys.data(), entries.data()),
                             Appender<CountTarget>{{}, &counters_->cells, 0});
  }

  template <bool kSwept>
  void lay_into_bins() {
    auto& keys = lists_.entries.template column<0>();
    auto& entries = lists_.entries.template column<1>();
    const Count count = lists_.entries.count(counters_);
    const EntryTarget laid = {keys.scratch(), entries.scratch()};
    backend_.for_each_append("place_bins", bins(), PlaceBin{w_.bin_counts.data(), w_.bin_begins.data()},
                             Appender<CountTarget>{{}, &counters_->entries_in_bins, 0});
    backend_.for_each(
        "lay_into_bins", count,
        LayIntoBin{w_.bins(), w_.bin_begins.data(), w_.partner_begin.data(), keys.data(), entries.data(), laid});
    backend_.for_each_append("prepare_in_bins", count,
                             PrepareInBin<Control, kSwept>{prepare_entry<kSwept>(laid.keys, laid.entries), w_.bins(),
                                                           w_.bin_begins.data(), w_.bin_counts.data(), keys.data()},
                             Appender<CountTarget>{{}, &counters_->cells, 0});
  }

  /// Brings the entries of each cell together, and prepares them for their tests.
  template <bool kSwept>
  void order_entries() {
    if constexpr (!Backend::kKnowsCounts) {
      if (w_.lays_into_bins) {
        lay_into_bins<kSwept>();
        return scan_tests();
      }
    }
    sort_entries<kSwept>();
    scan_tests();
  }

  void scan_tests() {
    backend_.exclusive_scan("scan_tests", lists_.entries.count(counters_), w_.partner_count.data(),
                            w_.test_offsets.data(), &counters_->tests);
    if (!settings_.partition.is_whole()) {
      const SampleTests sample_tests{lists_.entries.template column<0>().data(), w_.test_offsets.data(),
                                     lists_.entries.count(counters_), &counters_->tests, counters_->test_samples};
      backend_.for_each("sample_tests", {&counters_->all, kTestSamples}, sample_tests);
    }
  }

  template <bool kSwept, class Pairs>
  void test_share(Share share, const PairTest<kSwept>& test, Pairs& pairs) {
    backend_.begin(Stage::tests);
    const TestPair<Control, kSwept> test_pair{test, lists_.entries.template column<0>().data(), w_.boxed_entries.data(),
                                              w_.partner_begin.data()};
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_work_filtered("test_pairs", lists_.entries.count(counters_), w_.test_offsets.data(),
                                          &counters_->tests, share, test_pair, pairs.appender(counters_),
                                          lists_.patch_pairs.appender(counters_), lists_.flagged.appender(counters_));
        },
        pairs, lists_.patch_pairs, lists_.flagged);
  }

  template <bool kSwept, class Pairs>
  void expand_patch_pairs(Pairs& pairs) {
    if constexpr (kMayHavePatches) {
      if (scene_.patch_count > 0) expand_all_patch_pairs<kSwept>(pairs);
    }
  }

  template <bool kSwept, class Pairs>
  void expand_all_patch_pairs(Pairs& pairs) {
    const ExpandPatchPair<kSwept> expand{pair_test<kSwept>(), patch_bounds<kSwept>().data(),
                                         lists_.patch_pairs.template column<0>().data()};
    const auto expand_all = [&] {
      backend_.for_each_part_filtered("expand_patch_pairs", lists_.patch_pairs.count(counters_), expand,
                                      pairs.appender(counters_));
    };
    produce(backend_, counters_, expand_all, pairs);
  }

  template <bool kSwept, class Pairs>
  void add_remaining(const PairTest<kSwept>& test, Pairs& pairs) {
    if (lists_.flagged.capacity() > 0) {
      auto& flagged = lists_.flagged.template column<0>();
      backend_.sort_keys("sort_flagged", lists_.flagged.count(counters_), flagged,
                         32 + bits_for(scene_.element_count()));
      const auto keep_first = [&] { keep_first_of(lists_.flagged.count(counters_), flagged.data(), pairs); };
      produce(backend_, counters_, keep_first, pairs, lists_.patch_pairs);
    }
    if (lists_.bigs.capacity() == 0) return;
    const std::uint32_t all = scene_.patch_count > 0 ? scene_.patch_count : scene_.triangle_count;
    const std::uint64_t first = settings_.partition.rank.begin(all);
    const std::uint64_t end = settings_.partition.rank.end(all);
    const TestAgainstBig<kSwept> test_big{test, lists_.bigs.template column<0>().data(), lists_.bigs.count(counters_),
                                          static_cast<std::uint32_t>(first)};
    const auto test_against_big = [&] {
      backend_.for_each_append("test_against_big", {&counters_->all, end - first}, test_big, pairs.appender(counters_),
                               lists_.patch_pairs.appender(counters_));
    };
    produce(backend_, counters_, test_against_big, pairs, lists_.patch_pairs);
  }

  template <class Pairs>
  void keep_first_of(Count count, const std::uint64_t* sorted, Pairs& pairs) {
    if constexpr (Scheme::kMayBePartitioned) {
      if (!settings_.partition.is_whole()) {
        cells().keep_own_first(count, sorted, pairs.appender(counters_), lists_.patch_pairs.appender(counters_));
        return;
      }
    }
    backend_.for_each_append("keep_first", count, KeepFirst{sorted, scene_}, pairs.appender(counters_),
                             lists_.patch_pairs.appender(counters_));
  }

  void keep_patch_pairs(const Kdop18* present) {
    if (scene_.is_swept) {
      keep_patch_pairs<true>(present);
    } else {
      keep_patch_pairs<false>(present);
    }
  }

  template <bool kSwept>
  void keep_patch_pairs(const Kdop18* present) {
    const KeepPatchPair<kSwept> keep{{pair_test<false>(w_.volumes.data(), nullptr), patch_bounds<false>().data(),
                                      lists_.patch_pairs.template column<0>().data()},
                                     pair_test<kSwept>(present)};
    const auto keep_all = [&] {
      backend_.for_each_part_filtered("keep_patch_pairs", lists_.patch_pairs.count(counters_), keep,
                                      w_.kept().pairs.appender(counters_), lists_.pairs.appender(counters_));
    };
    produce(backend_, counters_, keep_all, w_.kept().pairs, lists_.pairs);
  }

  template <bool kSwept>
  void look_up_escaped() {
    const EscapedTriangles escaped{w_.kept().escaped.data(), &counters_->escaped};
    EscapedGroup* const groups = w_.kept().escaped_groups.data();
    backend_.for_each("bound_escaped", Count{&counters_->all, kMostEscaped / kEscapedGroup},
                      BoundEscaped{escaped, scene_.triangle_body, w_.volumes.data(), groups});
    const LookUpEscaped<kSwept> look_up{pair_test<kSwept>(), escaped, groups};
    const auto look_up_all = [&] {
      backend_.for_each_append("look_up_escaped", triangles(), look_up, lists_.pairs.appender(counters_));
    };
    produce(backend_, counters_, look_up_all, lists_.pairs);
  }

  void test_kept_pairs(const Kdop18* present, std::uint32_t left_out) {
    if (scene_.is_swept) {
      test_kept_pairs<true>(present, left_out);
    } else {
      test_kept_pairs<false>(present, left_out);
    }
  }

  template <bool kSwept>
  void test_kept_pairs(const Kdop18* present, std::uint32_t left_out) {
    backend_.begin(Stage::tests);
    const TestKept<kSwept> test_kept{pair_test<kSwept>(present), w_.kept().pairs.template column<0>().data(), left_out};
    const auto test_all = [&] {
      backend_.for_each_append("test_kept", w_.kept().pairs.count(counters_), test_kept,
                               lists_.pairs.appender(counters_));
    };
    produce(backend_, counters_, test_all, lists_.pairs);
  }

  template <bool kSwept>
  PairTest<kSwept> pair_test() {
    return pair_test<kSwept>(w_.volumes.data());
  }
  template <bool kSwept>
  PairTest<kSwept> pair_test(const Kdop18* volumes) {
    return pair_test<kSwept>(volumes, scene_.has_certain_slabs() ? w_.slabs.data() : nullptr);
  }
  /// Returns a test that finds all pairs whose volumes overlap if `slabs` is null.
  template <bool kSwept>
  PairTest<kSwept> pair_test(const Kdop18* volumes, const SlabReach* slabs) {
    return {scene_, volumes, w_.end_volumes.data(), w_.shapes.data(), slabs};
  }

  Count bins() const { return {&counters_->all, w_.bins().count()}; }
  Count patches() const { return {&counters_->all, scene_.patch_count}; }
  Count triangles() const { return {&counters_->scene.triangles, scene_.triangle_count}; }

  Backend& backend_;
  Workspace<Backend, Scheme>& w_;
  Lists<Backend, Scheme>& lists_;
  Counters* counters_;
  const SceneView& scene_;
  const DetectionSettings& settings_;
};

}  // namespace softcd

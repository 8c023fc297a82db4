#pragma once

#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/exact_cells.hpp"
#include "softcd/pipeline/produce.hpp"
#include "softcd/pipeline/stage_clock.hpp"
#include "softcd/pipeline/workspace.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/cell_ranges.hpp"
#include "softcd/stages/grid_parameters.hpp"
#include "softcd/stages/pair_tests.hpp"

/// The broad phase's stage order, once for all backends: triangles in, triangle pairs out.
namespace softcd {

constexpr int kEntryKeyBits = 3 * kCellBits + 3;

constexpr int bits_for(std::uint64_t count) {
  int bits = 0;
  while (bits < 64 && (count >> bits) != 0) ++bits;
  return bits;
}

/// `Scheme` says how triangles get their cells, and in which of them a pair is tested; as ExactScheme.
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

  /// Everything before the pair tests.
  void prepare() {
    bound_triangles();
    const SizeHistograms sizes = measure_triangles();
    typename Scheme::template Cells<Backend> cells(backend_, w_, scene_, settings_);
    backend_.run_once("choose_grid", cells.choose_grid(sizes));
    backend_.begin(Stage::assignment);
    cells.register_triangles();
    if (cells.subdivides() && lists_.splits.capacity() > 0) {
      backend_.begin(Stage::subdivision);
      count_children();
      cells.register_children(lists_.splits.count(counters_));
    }
    prepare_entries();
  }

  /// A share of the pairs that meet in cells.
  void test_pairs(Share share) {
    backend_.begin(Stage::tests);
    if (scene_.is_swept) {
      test_share<true>(share);
    } else {
      test_share<false>(share);
    }
  }

  /// Once all shares are tested: the pairs that had to be made unique, and those with the BIG list.
  void add_remaining_pairs() {
    if (lists_.flagged.capacity() > 0) {
      auto& flagged = lists_.flagged.template column<0>();
      backend_.sort_keys("sort_flagged", lists_.flagged.count(counters_), flagged,
                         32 + bits_for(scene_.triangle_count));
      append_pairs([&] {
        backend_.for_each_append("keep_first", lists_.flagged.count(counters_), KeepFirst{flagged.data()},
                                 lists_.pairs.appender(counters_));
      });
    }
    if (lists_.bigs.capacity() == 0) return;
    if (scene_.is_swept) {
      test_against_big<true>();
    } else {
      test_against_big<false>();
    }
  }

 private:
  using Control = typename Scheme::Control;

  void bound_triangles() {
    backend_.begin(Stage::volumes);
    w_.volumes.reserve(backend_, scene_.triangle_count, 0);
    w_.shapes.reserve(backend_, scene_.triangle_count, 0);
    if (scene_.is_swept) w_.end_volumes.reserve(backend_, scene_.triangle_count, 0);
    backend_.for_each("bound_triangles", triangles(),
                      BoundTriangle{scene_, w_.volumes.data(), w_.end_volumes.data(), w_.shapes.data()});
  }

  SizeHistograms measure_triangles() {
    constexpr int kBins = MeasureTriangle::kHistograms * kSizeBins;
    w_.size_bins.reserve(backend_, kBins, 0);
    std::uint32_t* bins = w_.size_bins.data();
    backend_.histogram("measure_triangles", triangles(), bins, MeasureTriangle::kHistograms, kSizeBins,
                       MeasureTriangle{w_.volumes.data(), w_.shapes.data()});
    return {bins + MeasureTriangle::at_rest * kSizeBins, bins + MeasureTriangle::swept * kSizeBins,
            bins + MeasureTriangle::extent * kSizeBins, bins + MeasureTriangle::distance * kSizeBins};
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

  void prepare_entries() {
    backend_.begin(Stage::sort);
    backend_.sort_pairs("sort_entries", lists_.entries.count(counters_), lists_.entries.template column<0>(),
                        lists_.entries.template column<1>(), kEntryKeyBits);
    w_.boxed_entries.reserve(backend_, lists_.entries.capacity(), 0);
    w_.partner_begin.reserve(backend_, lists_.entries.capacity(), 0);
    w_.partner_count.reserve(backend_, lists_.entries.capacity(), 0);
    w_.test_offsets.reserve(backend_, lists_.entries.capacity(), 0);
    const PrepareEntry<Control> prepare_entry{scene_,
                                              w_.volumes.data(),
                                              scene_.is_swept ? w_.end_volumes.data() : nullptr,
                                              &counters_->grid,
                                              lists_.entries.template column<0>().data(),
                                              lists_.entries.template column<1>().data(),
                                              w_.boxed_entries.data(),
                                              w_.partner_begin.data(),
                                              w_.partner_count.data()};
    backend_.for_each_append("prepare_entries", lists_.entries.count(counters_), prepare_entry,
                             Appender<CountTarget>{{}, &counters_->cells, 0});
    backend_.exclusive_scan("scan_tests", lists_.entries.count(counters_), w_.partner_count.data(),
                            w_.test_offsets.data(), &counters_->tests);
  }

  template <bool kSwept>
  void test_share(Share share) {
    const TestPair<Control, kSwept> test_pair{pair_test<kSwept>(), lists_.entries.template column<0>().data(),
                                              w_.boxed_entries.data(), w_.partner_begin.data()};
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_work_filtered("test_pairs", lists_.entries.count(counters_), w_.test_offsets.data(),
                                          &counters_->tests, share, test_pair, lists_.pairs.appender(counters_),
                                          lists_.flagged.appender(counters_));
        },
        lists_.pairs, lists_.flagged);
  }

  template <bool kSwept>
  PairTest<kSwept> pair_test() {
    return {scene_, w_.volumes.data(), w_.end_volumes.data(), w_.shapes.data()};
  }

  template <bool kSwept>
  void test_against_big() {
    const TestAgainstBig<kSwept> test_big{pair_test<kSwept>(), lists_.bigs.template column<0>().data(),
                                          lists_.bigs.count(counters_)};
    append_pairs(
        [&] { backend_.for_each_append("test_against_big", triangles(), test_big, lists_.pairs.appender(counters_)); });
  }

  template <class Work>
  void append_pairs(const Work& stage) {
    produce(backend_, counters_, stage, lists_.pairs);
  }

  Count triangles() const { return {&counters_->scene.triangles, scene_.triangle_count}; }

  Backend& backend_;
  Workspace<Backend, Scheme>& w_;
  Lists<Backend, Scheme>& lists_;
  Counters* counters_;
  const SceneView& scene_;
  const DetectionSettings& settings_;
};

}  // namespace softcd

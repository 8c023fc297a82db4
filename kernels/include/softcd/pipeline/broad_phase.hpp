#pragma once

#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/produce.hpp"
#include "softcd/pipeline/stage_clock.hpp"
#include "softcd/pipeline/workspace.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/cell_ranges.hpp"
#include "softcd/stages/grid_parameters.hpp"
#include "softcd/stages/pair_tests.hpp"
#include "softcd/stages/paper_assignment.hpp"
#include "softcd/stages/split_cells.hpp"

/// The broad phase's stage order, once for all backends: triangles in, triangle pairs out.
namespace softcd {

constexpr int kEntryKeyBits = 3 * kCellBits + 3;

constexpr int bits_for(std::uint64_t count) {
  int bits = 0;
  while (bits < 64 && (count >> bits) != 0) ++bits;
  return bits;
}

template <class Backend>
class BroadPhaseStages {
 public:
  BroadPhaseStages(Backend& backend, Workspace<Backend>& workspace, const SceneView& scene,
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
    choose_grid();
    if (settings_.broad_phase == BroadPhase::paper) {
      assign_cells<PaperControl>();
    } else {
      assign_cells<ExactControl>();
    }
  }

  /// A share of the pairs that meet in cells.
  void test_pairs(Share share) {
    if (settings_.broad_phase == BroadPhase::paper) {
      test_pairs<PaperControl>(share);
    } else {
      test_pairs<ExactControl>(share);
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
  void bound_triangles() {
    backend_.begin(Stage::volumes);
    w_.volumes.reserve(backend_, scene_.triangle_count, 0);
    w_.shapes.reserve(backend_, scene_.triangle_count, 0);
    if (scene_.is_swept) w_.end_volumes.reserve(backend_, scene_.triangle_count, 0);
    backend_.for_each("bound_triangles", triangles(),
                      BoundTriangle{scene_, w_.volumes.data(), w_.end_volumes.data(), w_.shapes.data()});
  }

  void choose_grid() {
    constexpr int kBins = MeasureTriangle::kHistograms * kSizeBins;
    w_.size_bins.reserve(backend_, kBins, 0);
    std::uint32_t* bins = w_.size_bins.data();
    backend_.histogram("measure_triangles", triangles(), bins, MeasureTriangle::kHistograms, kSizeBins,
                       MeasureTriangle{w_.volumes.data(), w_.shapes.data()});
    backend_.run_once(
        "choose_grid",
        ChooseGrid{bins + MeasureTriangle::at_rest * kSizeBins, bins + MeasureTriangle::swept * kSizeBins,
                   bins + MeasureTriangle::extent * kSizeBins, bins + MeasureTriangle::distance * kSizeBins,
                   settings_.broad_phase, settings_.subdivision, settings_.lambda, &counters_->grid});
  }

  template <class Control>
  void assign_cells() {
    constexpr bool kByPaper = std::is_same_v<Control, PaperControl>;
    using Register = std::conditional_t<kByPaper, RegisterTriangleByPaper, RegisterTriangle>;
    backend_.begin(Stage::assignment);
    const bool split = settings_.subdivision && settings_.broad_phase != BroadPhase::uniform;
    const Register register_triangle{scene_, w_.volumes.data(), w_.shapes.data(), &counters_->grid, split};
    produce(
        backend_, counters_,
        [&] {
          const auto register_all = [&](auto&... lists) {
            if constexpr (kByPaper) {
              backend_.for_each_append("register_triangles", triangles(), register_triangle,
                                       lists.appender(counters_)...);
            } else {
              backend_.for_each_part("register_triangles", triangles(), register_triangle,
                                     lists.appender(counters_)...);
            }
          };
          register_all(lists_.entries, lists_.splits, lists_.bigs);
        },
        lists_.entries, lists_.splits, lists_.bigs);
    if (split && lists_.splits.capacity() > 0) {
      backend_.begin(Stage::subdivision);
      subdivide<kByPaper>();
    }

    backend_.begin(Stage::sort);
    backend_.sort_pairs("sort_entries", lists_.entries.count(counters_), lists_.entries.template column<0>(),
                        lists_.entries.template column<1>(), kEntryKeyBits);
    w_.boxed_entries.reserve(backend_, lists_.entries.capacity(), 0);
    w_.partner_begin.reserve(backend_, lists_.entries.capacity(), 0);
    w_.partner_count.reserve(backend_, lists_.entries.capacity(), 0);
    w_.test_offsets.reserve(backend_, lists_.entries.capacity(), 0);
    const PrepareEntry<Control> prepare_entry{scene_,
                                              w_.volumes.data(),
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

  /// Children of the split triangles, their cells, and one entry per (cell, root).
  template <bool kByPaper>
  void subdivide() {
    const Count splits = lists_.splits.count(counters_);
    w_.child_counts.reserve(backend_, lists_.splits.capacity(), 0);
    w_.child_offsets.reserve(backend_, lists_.splits.capacity(), 0);
    backend_.for_each("count_children", splits,
                      CountChildren{lists_.splits.template column<0>().data(), w_.child_counts.data()});
    backend_.exclusive_scan("scan_children", splits, w_.child_counts.data(), w_.child_offsets.data(),
                            &counters_->children);
    if constexpr (kByPaper) {
      register_children_by_paper(splits);
    } else {
      mark_children(splits);
    }
  }

  void mark_children(Count splits) {
    const SplitRoot* roots = lists_.splits.template column<0>().data();
    w_.split_boxes.reserve(backend_, lists_.splits.capacity(), 0);
    w_.word_counts.reserve(backend_, lists_.splits.capacity(), 0);
    w_.word_offsets.reserve(backend_, lists_.splits.capacity(), 0);
    backend_.for_each(
        "bound_splits", splits,
        BoundSplit{w_.volumes.data(), roots, &counters_->grid, w_.split_boxes.data(), w_.word_counts.data()});
    produce(
        backend_, counters_,
        [&] {
          backend_.exclusive_scan("scan_split_words", splits, w_.word_counts.data(), w_.word_offsets.data(),
                                  &counters_->split_words);
        },
        lists_.split_words);
    const SplitBits bits{w_.split_boxes.data(), w_.word_offsets.data(), lists_.split_words.template column<0>().data(),
                         lists_.split_words.capacity()};
    backend_.for_each("clear_split_words", lists_.split_words.count(counters_), ClearWord{bits.words});
    backend_.for_each_work("mark_children", splits, w_.child_offsets.data(), &counters_->children,
                           MarkChild{scene_, w_.shapes.data(), roots, &counters_->grid, bits});
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_work("register_marked_cells", splits, w_.word_offsets.data(), &counters_->split_words,
                                 RegisterMarkedCells{scene_, w_.shapes.data(), roots, bits},
                                 lists_.entries.appender(counters_));
        },
        lists_.entries);
  }

  void register_children_by_paper(Count splits) {
    const SplitRoot* roots = lists_.splits.template column<0>().data();
    const RegisterChildByPaper register_child{scene_, w_.shapes.data(), roots, &counters_->grid};
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_work("register_children", splits, w_.child_offsets.data(), &counters_->children,
                                 register_child, lists_.split_cells.appender(counters_));
        },
        lists_.split_cells);
    const Count cells = lists_.split_cells.count(counters_);
    auto& keys = lists_.split_cells.template column<0>();
    auto& children = lists_.split_cells.template column<1>();
    backend_.sort_pairs("sort_split_cells", cells, keys, children, 3 * kCellBits + bits_for(scene_.triangle_count));
    w_.split_of_triangle.reserve(backend_, scene_.triangle_count, 0);
    backend_.for_each("index_splits", splits, IndexSplit{roots, w_.split_of_triangle.data()});
    const RegisterSplitCellByPaper register_cell{
        scene_, w_.shapes.data(), &counters_->grid, roots, w_.split_of_triangle.data(), keys.data(), children.data(),
        cells};
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_append("register_split_cells", cells, register_cell, lists_.entries.appender(counters_));
        },
        lists_.entries);
  }

  template <class Control>
  void test_pairs(Share share) {
    backend_.begin(Stage::tests);
    if (scene_.is_swept) {
      test_share(share, TestPair<Control, true>{pair_test<true>(), lists_.entries.template column<0>().data(),
                                                w_.boxed_entries.data(), w_.partner_begin.data()});
    } else {
      test_share(share, TestPair<Control, false>{pair_test<false>(), lists_.entries.template column<0>().data(),
                                                 w_.boxed_entries.data(), w_.partner_begin.data()});
    }
  }

  template <class Test>
  void test_share(Share share, const Test& test_pair) {
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
  Workspace<Backend>& w_;
  Lists<Backend>& lists_;
  Counters* counters_;
  const SceneView& scene_;
  const DetectionSettings& settings_;
};

}  // namespace softcd

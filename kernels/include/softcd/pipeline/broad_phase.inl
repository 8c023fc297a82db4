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
      : backend_(backend), w_(workspace), counters_(workspace.counters.data()), scene_(scene), settings_(settings) {}

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
    if (w_.flagged.capacity() > 0) {
      auto& flagged = w_.flagged.template column<0>();
      backend_.sort_keys("sort_flagged", w_.flagged.count(counters_), flagged, 32 + bits_for(scene_.triangle_count));
      append_pairs([&] {
        backend_.for_each_append("keep_first", w_.flagged.count(counters_), KeepFirst{flagged.data()},
                                 w_.pairs.appender(counters_));
      });
    }
    if (w_.bigs.capacity() == 0) return;
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
          register_all(w_.entries, w_.splits, w_.bigs);
        },
        w_.entries, w_.splits, w_.bigs);
    if (split && w_.splits.capacity() > 0) {
      backend_.begin(Stage::subdivision);
      subdivide<kByPaper>();
    }

    backend_.begin(Stage::sort);
    backend_.sort_pairs("sort_entries", w_.entries.count(counters_), w_.entries.template column<0>(),
                        w_.entries.template column<1>(), kEntryKeyBits);
    w_.boxed_entries.reserve(backend_, w_.entries.capacity(), 0);
    w_.partner_begin.reserve(backend_, w_.entries.capacity(), 0);
    w_.partner_count.reserve(backend_, w_.entries.capacity(), 0);
    w_.test_offsets.reserve(backend_, w_.entries.capacity(), 0);
    const PrepareEntry<Control> prepare_entry{scene_,
                                              w_.volumes.data(),
                                              w_.entries.template column<0>().data(),
                                              w_.entries.template column<1>().data(),
                                              w_.boxed_entries.data(),
                                              w_.partner_begin.data(),
                                              w_.partner_count.data()};
    backend_.for_each_append("prepare_entries", w_.entries.count(counters_), prepare_entry,
                             Appender<CountTarget>{{}, &counters_->cells, 0});
    backend_.exclusive_scan("scan_tests", w_.entries.count(counters_), w_.partner_count.data(), w_.test_offsets.data(),
                            &counters_->tests);
  }

  /// Children of the split triangles, their cells, and one entry per (cell, root).
  template <bool kByPaper>
  void subdivide() {
    const Count splits = w_.splits.count(counters_);
    w_.child_counts.reserve(backend_, w_.splits.capacity(), 0);
    w_.child_offsets.reserve(backend_, w_.splits.capacity(), 0);
    backend_.for_each("count_children", splits,
                      CountChildren{w_.splits.template column<0>().data(), w_.child_counts.data()});
    backend_.exclusive_scan("scan_children", splits, w_.child_counts.data(), w_.child_offsets.data(),
                            &counters_->children);
    if constexpr (kByPaper) {
      register_children_by_paper(splits);
    } else {
      mark_children(splits);
    }
  }

  void mark_children(Count splits) {
    const SplitRoot* roots = w_.splits.template column<0>().data();
    w_.split_boxes.reserve(backend_, w_.splits.capacity(), 0);
    w_.word_counts.reserve(backend_, w_.splits.capacity(), 0);
    w_.word_offsets.reserve(backend_, w_.splits.capacity(), 0);
    backend_.for_each(
        "bound_splits", splits,
        BoundSplit{w_.volumes.data(), roots, &counters_->grid, w_.split_boxes.data(), w_.word_counts.data()});
    produce(
        backend_, counters_,
        [&] {
          backend_.exclusive_scan("scan_split_words", splits, w_.word_counts.data(), w_.word_offsets.data(),
                                  &counters_->split_words);
        },
        w_.split_words);
    const SplitBits bits{w_.split_boxes.data(), w_.word_offsets.data(), w_.split_words.template column<0>().data(),
                         w_.split_words.capacity()};
    backend_.for_each("clear_split_words", w_.split_words.count(counters_), ClearWord{bits.words});
    backend_.for_each_work("mark_children", splits, w_.child_offsets.data(), &counters_->children,
                           MarkChild{scene_, w_.shapes.data(), roots, &counters_->grid, bits});
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_work("register_marked_cells", splits, w_.word_offsets.data(), &counters_->split_words,
                                 RegisterMarkedCells{scene_, w_.shapes.data(), roots, bits},
                                 w_.entries.appender(counters_));
        },
        w_.entries);
  }

  void register_children_by_paper(Count splits) {
    const SplitRoot* roots = w_.splits.template column<0>().data();
    const RegisterChildByPaper register_child{scene_, w_.shapes.data(), roots, &counters_->grid};
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_work("register_children", splits, w_.child_offsets.data(), &counters_->children,
                                 register_child, w_.split_cells.appender(counters_));
        },
        w_.split_cells);
    const Count cells = w_.split_cells.count(counters_);
    auto& keys = w_.split_cells.template column<0>();
    auto& children = w_.split_cells.template column<1>();
    backend_.sort_pairs("sort_split_cells", cells, keys, children, 3 * kCellBits + bits_for(scene_.triangle_count));
    w_.split_of_triangle.reserve(backend_, scene_.triangle_count, 0);
    backend_.for_each("index_splits", splits, IndexSplit{roots, w_.split_of_triangle.data()});
    const RegisterSplitCellByPaper register_cell{
        scene_, w_.shapes.data(), &counters_->grid, roots, w_.split_of_triangle.data(), keys.data(), children.data(),
        cells};
    produce(
        backend_, counters_,
        [&] { backend_.for_each_append("register_split_cells", cells, register_cell, w_.entries.appender(counters_)); },
        w_.entries);
  }

  template <class Control>
  void test_pairs(Share share) {
    backend_.begin(Stage::tests);
    if (scene_.is_swept) {
      test_share(share, TestPair<Control, true>{pair_test<true>(), w_.entries.template column<0>().data(),
                                                w_.boxed_entries.data(), w_.partner_begin.data()});
    } else {
      test_share(share, TestPair<Control, false>{pair_test<false>(), w_.entries.template column<0>().data(),
                                                 w_.boxed_entries.data(), w_.partner_begin.data()});
    }
  }

  template <class Test>
  void test_share(Share share, const Test& test_pair) {
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_work_filtered("test_pairs", w_.entries.count(counters_), w_.test_offsets.data(),
                                          &counters_->tests, share, test_pair, w_.pairs.appender(counters_),
                                          w_.flagged.appender(counters_));
        },
        w_.pairs, w_.flagged);
  }

  template <bool kSwept>
  PairTest<kSwept> pair_test() {
    return {scene_, w_.volumes.data(), w_.end_volumes.data(), w_.shapes.data()};
  }

  template <bool kSwept>
  void test_against_big() {
    const TestAgainstBig<kSwept> test_big{pair_test<kSwept>(), w_.bigs.template column<0>().data(),
                                          w_.bigs.count(counters_)};
    append_pairs(
        [&] { backend_.for_each_append("test_against_big", triangles(), test_big, w_.pairs.appender(counters_)); });
  }

  template <class Work>
  void append_pairs(const Work& stage) {
    produce(backend_, counters_, stage, w_.pairs);
  }

  Count triangles() const { return {&counters_->scene.triangles, scene_.triangle_count}; }

  Backend& backend_;
  Workspace<Backend>& w_;
  Counters* counters_;
  const SceneView& scene_;
  const DetectionSettings& settings_;
};

}  // namespace softcd

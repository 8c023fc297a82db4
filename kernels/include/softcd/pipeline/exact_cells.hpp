#pragma once

#include <cstdint>

#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/produce.hpp"
#include "softcd/pipeline/workspace.hpp"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/grid_parameters.hpp"
#include "softcd/stages/patches.hpp"
#include "softcd/stages/shared_pairs.hpp"
#include "softcd/stages/split_cells.hpp"

namespace softcd {

template <class Backend>
class ExactCells;

/// The scheme of the broad phases `exact` and `uniform`: how triangles get their cells, and in which of their common
/// cells two triangles are tested.
struct ExactScheme {
  using Control = ExactControl;
  /// Several ranks may have a part each.
  static constexpr bool kMayBePartitioned = true;
  /// Patches of triangles may stand for these.
  static constexpr bool kMayHavePatches = true;
  /// A triangle that is represented by children.
  using Split = SplitRoot;
  /// The list that children mark their cells on, before these are entries.
  template <class Backend>
  using SplitCells = List<Backend, DetectionCounter<&Counters::split_cells>, ArrayTarget<std::uint32_t>,
                          typename Backend::template Buffer<std::uint32_t>>;
  template <class Backend>
  using Cells = ExactCells<Backend>;
};

/// Triangles in, entries out: the order of the stages in between.
template <class Backend>
class ExactCells {
 public:
  ExactCells(Backend& backend, Workspace<Backend, ExactScheme>& workspace, const SceneView& scene,
             const DetectionSettings& settings)
      : backend_(backend),
        w_(workspace),
        lists_(workspace.lists),
        counters_(workspace.counters.data()),
        scene_(scene),
        settings_(settings) {}

  bool subdivides() const { return settings_.subdivision && settings_.broad_phase != BroadPhase::uniform; }

  ChooseGrid choose_grid(const SizeHistograms& sizes) const {
    return {sizes, settings_.broad_phase, settings_.subdivision, settings_.cell_size_factor, &counters_->grid};
  }

  /// Registers whole triangles. Lists those to split and those to test against all others.
  void register_triangles() {
    if constexpr (Backend::kHasPatches) {
      if (scene_.patch_count > 0) {
        register_patches();
        register_triangles(lists_.loose.count(counters_), lists_.loose.template column<0>().data());
        return;
      }
    }
    register_triangles({&counters_->scene.triangles, scene_.triangle_count}, nullptr);
  }

  /// Registers split triangles, whose children must be counted, with one entry per cell.
  void register_children(Count split_count) {
    const SplitRoot* roots = lists_.splits.template column<0>().data();
    if (!settings_.partition.is_whole()) number_splits(split_count);
    w_.split_boxes.reserve(backend_, lists_.splits.capacity(), 0);
    w_.word_counts.reserve(backend_, lists_.splits.capacity(), 0);
    w_.word_offsets.reserve(backend_, lists_.splits.capacity(), 0);
    backend_.for_each(
        "bound_splits", split_count,
        BoundSplit{w_.volumes.data(), roots, &counters_->grid, w_.split_boxes.data(), w_.word_counts.data()});
    produce(
        backend_, counters_,
        [&] {
          backend_.exclusive_scan("scan_split_words", split_count, w_.word_counts.data(), w_.word_offsets.data(),
                                  &counters_->split_cells);
        },
        lists_.split_cells);
    const SplitBits bits = split_bits();
    backend_.for_each("clear_split_words", lists_.split_cells.count(counters_), ClearWord{bits.words});
    backend_.for_each_work("mark_children", split_count, w_.child_offsets.data(), &counters_->children,
                           MarkChild{scene_, w_.shapes.data(), roots, &counters_->grid, bits});
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_work("register_marked_cells", split_count, w_.word_offsets.data(), &counters_->split_cells,
                                 RegisterMarkedCells{scene_, w_.shapes.data(), roots, bits, settings_.partition},
                                 w_.entry_appender());
        },
        lists_.entries);
  }

  /// Does the work of KeepFirst if there are several ranks.
  template <class Pairs, class PatchPairs>
  void keep_own_first(Count count, const std::uint64_t* sorted, Pairs pairs, PatchPairs patch_pairs) {
    backend_.for_each_append("keep_own_first", count,
                             KeepOwnFirst{sorted, scene_, settings_.partition, w_.volumes.data(), &counters_->grid,
                                          w_.split_of.data(), split_bits()},
                             pairs, patch_pairs);
  }

 private:
  CellRegistrar registrar() {
    return {scene_, w_.volumes.data(), w_.shapes.data(), &counters_->grid, settings_.partition};
  }

  void register_patches() {
    const RegisterPatch register_patch{registrar()};
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_part("register_patches", Count{&counters_->all, scene_.patch_count}, register_patch,
                                 lists_.entries.appender(counters_), lists_.loose.appender(counters_),
                                 lists_.patch_pairs.appender(counters_));
        },
        lists_.entries, lists_.loose, lists_.patch_pairs);
  }

  /// Registers all triangles, or those of a list.
  void register_triangles(Count count, const std::uint32_t* triangles) {
    const RegisterTriangle register_triangle{registrar(), subdivides(), triangles};
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_part("register_triangles", count, register_triangle, w_.entry_appender(),
                                 lists_.splits.appender(counters_), lists_.bigs.appender(counters_));
        },
        lists_.entries, lists_.splits, lists_.bigs);
  }

  void number_splits(Count split_count) {
    w_.split_of.reserve(backend_, scene_.triangle_count, 0);
    backend_.for_each("forget_splits", {&counters_->scene.triangles, scene_.triangle_count},
                      ForgetSplit{w_.split_of.data()});
    backend_.for_each("number_splits", split_count,
                      NumberSplit{lists_.splits.template column<0>().data(), w_.split_of.data()});
  }

  SplitBits split_bits() {
    return {w_.split_boxes.data(), w_.word_offsets.data(), lists_.split_cells.template column<0>().data(),
            lists_.split_cells.capacity()};
  }

  Backend& backend_;
  Workspace<Backend, ExactScheme>& w_;
  Lists<Backend, ExactScheme>& lists_;
  Counters* counters_;
  const SceneView& scene_;
  const DetectionSettings& settings_;
};

}  // namespace softcd

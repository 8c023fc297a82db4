#pragma once

#include "paper/assignment.hpp"
#include "paper/choose_grid.hpp"
#include "softcd/pipeline/broad_phase.hpp"

/// The broad phase as printed in Wong, Leach, Zambetta 2012, for a DetectorOn. It LOSES some true pairs, and exists
/// only for comparison. Everything before and after the assignment of cells is the detector's own.
namespace softcd::paper {

template <class Backend>
class Cells;

struct Scheme {
  using Control = paper::Control;
  static constexpr bool kMayBePartitioned = false;
  static constexpr bool kMayHavePatches = false;
  using Split = paper::Split;
  template <class Backend>
  using SplitCells =
      List<Backend, DetectionCounter<&Counters::split_cells>, SplitCellTarget,
           typename Backend::template SortBuffer<std::uint64_t>, typename Backend::template SortBuffer<std::uint32_t>>;
  template <class Backend>
  using Cells = paper::Cells<Backend>;
};

/// Turns triangles into entries, as ExactCells does.
template <class Backend>
class Cells {
 public:
  Cells(Backend& backend, Workspace<Backend, Scheme>& workspace, const SceneView& scene,
        const DetectionSettings& settings)
      : backend_(backend),
        w_(workspace),
        lists_(workspace.lists),
        counters_(workspace.counters.data()),
        scene_(scene),
        settings_(settings) {}

  bool subdivides() const { return settings_.subdivision; }

  ChooseGrid choose_grid(const SizeHistograms& sizes) const {
    return {sizes, settings_.subdivision, settings_.cell_size_factor, &counters_->grid};
  }

  void register_triangles() {
    const RegisterTriangle register_triangle{scene_, w_.volumes.data(), w_.shapes.data(), &counters_->grid,
                                             subdivides()};
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_append("register_triangles", triangles(), register_triangle, w_.entry_appender(),
                                   lists_.splits.appender(counters_), lists_.bigs.appender(counters_));
        },
        lists_.entries, lists_.splits, lists_.bigs);
  }

  void register_children(Count split_count) {
    const Split* splits = lists_.splits.template column<0>().data();
    const RegisterChild register_child{scene_, w_.shapes.data(), splits, &counters_->grid};
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_work("register_children", split_count, w_.child_offsets.data(), &counters_->children,
                                 register_child, lists_.split_cells.appender(counters_));
        },
        lists_.split_cells);
    const Count cells = lists_.split_cells.count(counters_);
    auto& keys = lists_.split_cells.template column<0>();
    auto& children = lists_.split_cells.template column<1>();
    backend_.sort_pairs("sort_split_cells", cells, keys, children, kCellBits + bits_for(scene_.triangle_count));
    const RegisterSplitCell register_cell{
        scene_, w_.shapes.data(), &counters_->grid, splits, keys.data(), children.data(), cells};
    produce(
        backend_, counters_,
        [&] { backend_.for_each_append("register_split_cells", cells, register_cell, w_.entry_appender()); },
        lists_.entries);
  }

 private:
  Count triangles() const { return {&counters_->scene.triangles, scene_.triangle_count}; }

  Backend& backend_;
  Workspace<Backend, Scheme>& w_;
  Lists<Backend, Scheme>& lists_;
  Counters* counters_;
  const SceneView& scene_;
  const DetectionSettings& settings_;
};

}  // namespace softcd::paper

#pragma once

#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/produce.hpp"
#include "softcd/pipeline/stage_clock.hpp"
#include "softcd/pipeline/workspace.hpp"
#include "softcd/stages/sweep.hpp"

namespace softcd {

/// Most triangles of a scene that is swept.
constexpr std::uint32_t kMostSweptTriangles = 4096;

/// Replaces the grid for a scene of few triangles, if the host knows counts at once: triangles in, entries with their
/// partners out. The pair tests are those of the grid.
template <class Backend, class Scheme>
class SweepStages {
 public:
  SweepStages(Backend& backend, Workspace<Backend, Scheme>& workspace, const SceneView& scene,
              const DetectionSettings& settings)
      : backend_(backend),
        w_(workspace),
        entries_(workspace.lists.entries),
        counters_(workspace.counters.data()),
        scene_(scene),
        settings_(settings) {}

  /// Prepares entries. Returns false if the grid has to do it; then only the counters' grid has changed.
  template <bool kSwept>
  bool prepare() {
    if (!is_asked_for() || !choose()) return false;
    backend_.begin(Stage::assignment);
    register_triangles();
    backend_.begin(Stage::sort);
    backend_.sort_pairs("sort_entries", entries_.count(counters_), entries_.template column<0>(),
                        entries_.template column<1>(), kSweepKeyBits);
    prepare_entries<kSwept>();
    if (counters_->tests <= kMostSweepTests * counters_->entries) return true;
    entries_.rewind();
    counters_->entries = counters_->tests = 0;
    return false;
  }

 private:
  /// Whether no option asks for the grid's own cells, and no batches or ranks need the grid to separate them.
  bool is_asked_for() const {
    return scene_.triangle_count <= kMostSweptTriangles && settings_.broad_phase == BroadPhase::exact &&
           settings_.subdivision && !(settings_.cell_size_factor > 0.0F) && !scene_.has_batches &&
           settings_.partition.is_whole();
  }

  bool choose() {
    w_.sweep.reserve(backend_, 1, 0);
    backend_.run_once("choose_sweep",
                      ChooseSweep{w_.volumes.data(), w_.shapes.data(), triangles(), w_.sweep.data(), &counters_->grid});
    return w_.sweep.data()->is_possible;
  }

  void register_triangles() {
    const RegisterForSweep register_triangle{scene_, w_.volumes.data(), w_.shapes.data(), w_.sweep.data()};
    const auto register_all = [&] {
      backend_.for_each_append("register_for_sweep", triangles(), register_triangle, entries_.appender(counters_));
    };
    produce(backend_, counters_, register_all, entries_);
  }

  template <bool kSwept>
  void prepare_entries() {
    w_.reserve_entries(backend_);
    const PrepareSweptEntry<kSwept> prepare_entry{w_.volumes.data(),
                                                  kSwept ? w_.end_volumes.data() : nullptr,
                                                  w_.sweep.data(),
                                                  entries_.count(counters_),
                                                  entries_.template column<0>().data(),
                                                  entries_.template column<1>().data(),
                                                  w_.boxed_entries.data(),
                                                  w_.partner_begin.data(),
                                                  w_.partner_count.data()};
    backend_.for_each("prepare_swept_entries", entries_.count(counters_), prepare_entry);
    backend_.exclusive_scan("scan_tests", entries_.count(counters_), w_.partner_count.data(), w_.test_offsets.data(),
                            &counters_->tests);
  }

  Count triangles() const { return {&counters_->scene.triangles, scene_.triangle_count}; }

  Backend& backend_;
  Workspace<Backend, Scheme>& w_;
  decltype(Workspace<Backend, Scheme>::lists.entries)& entries_;
  Counters* counters_;
  const SceneView& scene_;
  const DetectionSettings& settings_;
};

}  // namespace softcd

#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <new>
#include <optional>

#include "softcd/pipeline/chunk_plan.hpp"
#include "softcd/pipeline/detector_memory.hpp"
#include "softcd/pipeline/narrow_phase.hpp"
#include "softcd/pipeline/pair_keeping.hpp"
#include "softcd/pipeline/staying_contacts.hpp"

namespace softcd {

/// The stage order of a whole detection, once for all backends: positions in, sorted contacts out. The lists may turn
/// out to be too short; then it runs again.
template <class Backend, class Scheme>
class DetectionStages {
  using BroadPhase = BroadPhaseStages<Backend, Scheme>;
  using NarrowPhase = NarrowPhaseStages<Backend, Scheme>;
  using Wanted = typename BroadPhase::Wanted;

  /// Most tests of a chunk if memory is short and counts are known at once: about 20 milliseconds of work. So the first
  /// chunks show what tests lead to before all are made.
  static constexpr std::uint64_t kMostTestsOfChunk = 1ULL << 22;

 public:
  /// The scene's view is that of the detection. `revision` is the detector's. `bodies` must be valid until the first
  /// launch() returns.
  DetectionStages(DetectorMemory<Backend, Scheme>& memory, QueryOn<Backend>& query, const SceneBodies& bodies,
                  const DetectionSettings& settings, std::uint64_t revision)
      : account_(*memory.account),
        scene_(memory.scene),
        w_(memory.workspace),
        backend_(memory.backend),
        query_(query),
        settings_(settings),
        revision_(revision),
        given_bodies_(bodies),
        body_ids_(settings.contacts_stay && !bodies.bodies.empty() ? bodies.bodies[bodies.bodies.size() - 1].id + 1
                                                                   : 0),
        chunks_(query.revision == revision ? query.chunks : 1),
        may_keep_(settings.reuses_pairs && chunks_.count() == 1 && !account_.is_limited() &&
                  settings.partition.is_whole()) {}
  DetectionStages(const DetectionStages&) = delete;
  DetectionStages& operator=(const DetectionStages&) = delete;

  ChunkPlan& chunks() { return chunks_; }
  const ChunkPlan& chunks() const { return chunks_; }
  /// Whether the detection reuses pairs of an earlier one.
  bool has_reused() const { return has_reused_; }

  /// Enqueues the detection. On the CPU it has run when this returns.
  void launch() {
    is_all_enqueued_ = false;
    w_.counters.reserve(backend_, 1, 0);
    // Samples of several ranks' tests are of entries in the order of cells. Bins take memory.
    w_.lays_into_bins = !Backend::kKnowsCounts && query_.lays_into_bins && settings_.partition.is_whole() &&
                        !account_.is_limited() && w_.lists.entries.capacity() <= kMostEntriesInBins;
    if (may_keep_ && !has_reused_) {
      keeping_.emplace(backend_, w_, scene_.view(), host_bodies(), settings_, revision_, query_.usefulness);
    }
    if constexpr (Backend::kKnowsCounts) {
      *w_.counters.data() = {};
      backend_.launch(signature(LaunchPart::whole),
                      [this] { detect([](LaunchPart /*part*/, const auto& run) { run(); }); });
    } else {
      detect([this](LaunchPart part, const auto& enqueue) { backend_.launch(signature(part), enqueue); });
    }
    if (settings_.contacts_stay) ready_ = backend_.mark_end();
    is_all_enqueued_ = !Backend::kKnowsCounts;
  }

  /// Returns the contacts if they stay on the backend and all is enqueued.
  StayingContacts staying() const {
    if (!is_all_enqueued_) return {};
    return {query_.contacts.data(),
            w_.lists.found.capacity(),
            query_.contact_counts.data(),
            query_.body_begin.data(),
            body_ids_,
            ready_};
  }

  /// Reserves memory for so many contacts in order.
  void reserve_sorted_contacts(std::uint64_t count) {
    query_.contacts.reserve(backend_, count, 0);
    w_.contact_keys.reserve(backend_, count, 0);
    w_.contact_order.reserve(backend_, count, 0);
  }

  /// Grows the list of kept pairs if it was too short. Returns whether it was.
  bool grow_kept_pairs(const Counters& counters) {
    return may_keep_ && grow_lists(backend_, counters, w_.kept().pairs);
  }
  /// Lets the next launch() keep nothing, as a list was too short for this one. It reuses pairs if this one did.
  void keep_nothing() {
    if (may_keep_ && !has_reused_) keeping_->drop();
    may_keep_ = has_reused_;
  }
  /// Lets the next launch() neither keep nor reuse pairs, as memory is short.
  void forget_kept() { may_keep_ = has_reused_ = false; }

  /// Ends the detection, of which all has run. If the positions were not as predicted, it found nothing, and nothing is
  /// learnt.
  void conclude(const Counters& counters) {
    is_all_enqueued_ = true;
    if (counters.all == 0 || has_reused_) return;
    w_.has_split = counters.splits > 0;
    if (may_keep_) keeping_->conclude(counters);
  }

 private:
  /// Launches a detection. There are two launches if the host first waits for the comparison that tells whether kept
  /// pairs can be reused. A repeated detection knows the result.
  template <class Launch>
  void detect(const Launch& launch) {
    const bool waits = may_keep_ && (has_reused_ || keeping_->waits_for_comparison());
    if (waits) {
      launch(LaunchPart::comparison, [this] { bound_triangles(); });
      if (!has_reused_) has_reused_ = keeping_->is_served(backend_.read(w_.counters));
    }
    if (may_keep_ && !has_reused_) keeping_->begin();
    const LaunchPart rest = !waits ? LaunchPart::whole : has_reused_ ? LaunchPart::reuse : LaunchPart::remainder;
    launch(rest, [&] {
      if (!waits) bound_triangles();
      find_contacts();
    });
  }

  /// Bounds the triangles, and compares their volumes with the kept ones.
  void bound_triangles() {
    w_.lists.with_all([](auto&... lists) { (lists.rewind(), ...); });
    w_.contact_keys.rewind();
    w_.contact_order.rewind();
    backend_.run_once("clear_counters",
                      ClearCounters{w_.counters.data(), scene_.counts(), scene_.verdict().is_as_predicted});
    BroadPhase broad_phase(backend_, w_, scene_.view(), settings_);
    broad_phase.bound_triangles();
    if (may_keep_) keeping_->enqueue_comparison(broad_phase);
  }

  /// Finds the contacts. The triangles must be bounded.
  void find_contacts() {
    BroadPhase broad_phase(backend_, w_, scene_.view(), settings_);
    NarrowPhase narrow_phase(backend_, scene_.mirror(), w_, scene_.view(), settings_, scene_.counts());
    if (may_keep_ && !has_reused_) keeping_->enqueue_volumes(broad_phase);
    narrow_phase.reserve_neighbours();
    bool in_runs = false;
    const auto reserve_order = [&] {
      reserve_sorted_contacts(w_.lists.found.capacity());
      in_runs = query_.orders_in_runs && has_runs(narrow_phase);
    };
    if (!Backend::kKnowsCounts) reserve_order();
    const auto enqueue_pairs = [&] { find_pairs_or_reuse(broad_phase, narrow_phase); };
    const auto count_in_runs = [&] {
      if (!Backend::kKnowsCounts && in_runs) narrow_phase.count_in_runs();
    };
    if (Backend::kKnowsCounts || chunks_.count() > 1) {  // each chunk's candidates are counted from 0
      count_in_runs();
      enqueue_pairs();
      backend_.begin(Stage::features);
      narrow_phase.test_neighbours();
    } else {
      backend_.concurrently(enqueue_pairs, [&] {
        count_in_runs();
        narrow_phase.test_neighbours();
      });
    }
    narrow_phase.find_contacts();
    if (Backend::kKnowsCounts) reserve_order();
    narrow_phase.order_contacts(query_.contacts.data(), in_runs);
    backend_.begin(Stage::transfer);
    const Count found = w_.lists.found.count(w_.counters.data());
    if (settings_.contacts_stay) conclude_contacts(found);
    backend_.download(w_.counters, query_.contacts, found, !settings_.contacts_stay);
  }

  /// Prepares ranges of bodies and counts for callers that read contacts in the backend's memory.
  void conclude_contacts(Count found) {
    const std::uint64_t ranges = 2 * std::uint64_t{body_ids_} + 1;
    query_.body_begin.reserve(backend_, ranges, 0);
    query_.contact_counts.reserve(backend_, 1, 0);
    Counters* const counters = w_.counters.data();
    std::uint64_t* const body_begin = query_.body_begin.data();
    backend_.for_each("find_body_ranges", Count{&counters->all, ranges},
                      FindBodyRange{query_.contacts.data(), found, body_ids_, body_begin});
    const bool needs_short_runs = !Backend::kKnowsCounts && query_.orders_in_runs;
    w_.lists.with_all([&](auto&... lists) {
      backend_.run_once("conclude_contacts",
                        ConcludeContacts<kListCount + 1>{counters,
                                                         {lists.bound(counters)..., w_.kept().pairs.bound(counters)},
                                                         needs_short_runs,
                                                         body_begin + body_ids_,
                                                         query_.contact_counts.data()});
    });
  }

  /// Returns whether there is memory to order contacts in runs. Otherwise contacts are sorted by keys.
  bool has_runs(NarrowPhase& narrow_phase) {
    if (account_.is_limited()) return false;
    try {
      narrow_phase.reserve_runs();
      return true;
    } catch (const std::bad_alloc&) {
      w_.run_counts = {};
      w_.run_begins = {};
      return false;
    }
  }

  /// Finds the pairs among those that an earlier detection kept, and looks up triangles that have escaped. If that is
  /// not possible, searches all pairs.
  void find_pairs_or_reuse(BroadPhase& broad_phase, NarrowPhase& narrow_phase) {
    if (has_reused_) return keeping_->enqueue_reuse(broad_phase);
    if (may_keep_ && keeping_->work().keeps_pairs) {
      keeping_->with_kept_volumes([&] {
        broad_phase.prepare(Wanted::overlapping_volumes, keeping_->grows_volumes());
        keeping_->enqueue_pairs(broad_phase);
      });
      return;
    }
    broad_phase.prepare(Wanted::meeting_triangles, false);
    if (Backend::kKnowsCounts && (account_.is_limited() || chunks_.count() > 1)) {
      chunks_.require(w_.counters.data()->tests / kMostTestsOfChunk + 1);
    }
    find_pairs(broad_phase, narrow_phase);
  }

  /// Finds pairs in chunks, and the contacts of all chunks but the last.
  void find_pairs(BroadPhase& broad_phase, NarrowPhase& narrow_phase) {
    for (std::uint32_t i = 0; i < chunks_.count(); ++i) {
      if (i > 0) {
        broad_phase.expand_patch_pairs();
        narrow_phase.find_contacts();
        backend_.run_once("next_chunk", NextChunk{w_.counters.data()});
      }
      broad_phase.test_pairs(chunks_.begin(i));
    }
    broad_phase.add_remaining_pairs();
    broad_phase.expand_patch_pairs();
  }

  /// Returns the bodies on the host. Valid while the detection is started; on the CPU until it is finished.
  SceneBodies host_bodies() const {
    if constexpr (Backend::kKnowsCounts) {
      const SceneView& view = scene_.view();
      const std::size_t count = view.body_count;
      const std::size_t partners = count == 0 ? 0 : view.partner_begin[count];
      return {{view.bodies, count}, {view.partner_begin, count + 1}, {view.partners, partners}};
    } else {
      return given_bodies_;
    }
  }

  Signature signature(LaunchPart part) {
    return {part,
            may_keep_ ? keeping_->work() : KeepingWork{},
            w_.kept_number,
            w_.kept().pairs.capacity(),
            settings_,
            scene_.view(),
            scene_.counts(),
            chunks_.count(),
            query_.orders_in_runs,
            w_.lays_into_bins,
            body_ids_,
            scene_.verdict().is_as_predicted,
            w_.lists.with_all([](auto&... lists) { return std::array{lists.capacity()...}; })};
  }

  MemoryAccount& account_;
  const SceneOn<Backend>& scene_;
  Workspace<Backend, Scheme>& w_;
  Backend& backend_;
  QueryOn<Backend>& query_;
  const DetectionSettings settings_;
  const std::uint64_t revision_;
  const SceneBodies given_bodies_;  ///< until the first launch() returns
  const std::uint32_t body_ids_;    ///< where contacts stay; see DeviceContacts
  ChunkPlan chunks_;
  bool may_keep_;                                        ///< it may keep pairs for later detections, or reuse kept ones
  bool has_reused_ = false;                              ///< it reuses pairs of an earlier detection
  std::optional<PairKeeping<Backend, Scheme>> keeping_;  ///< set if may_keep_
  bool is_all_enqueued_ = false;                         ///< by the last launch; on the CPU, once it has run
  void* ready_ = nullptr;                                ///< see StayingContacts
};

}  // namespace softcd

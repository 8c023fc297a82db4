#pragma once

#include <algorithm>
#include <cstring>
#include <vector>

#include "softcd/pipeline/broad_phase.inl"
#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/narrow_phase.inl"
#include "softcd/pipeline/workspace.hpp"

namespace softcd {

/// The detector on one backend. A backend provides (see cpu/cpu_backend.hpp, the shorter one, for the signatures):
/// Buffer and SortBuffer, which own memory that grows or is released; run_once, for_each, for_each_append,
/// for_each_work, for_each_part and the `filtered` forms of the last two, exclusive_scan, sort_keys, sort_pairs,
/// histogram and minimum, which enqueue work in order; upload and download; launch, which runs a callable that enqueues
/// and may return early; finish, which waits; begin, which starts the clock of a part.
template <class Backend>
class DetectorOn final : public Detector {
  static constexpr std::uint32_t kMostChunks = 4096;

 public:
  template <class... Arguments>
  explicit DetectorOn(Arguments... arguments) : backend_(arguments...) {}

  void set_topology(const SceneTopology& topology) override {
    upload(w_.triangles, topology.triangles);
    upload(w_.triangle_edges, topology.triangle_edges);
    upload(w_.edges, topology.edges);
    upload(w_.ownership, topology.ownership);
    upload(w_.triangle_body, topology.triangle_body);
    upload(w_.vertex_body, topology.vertex_body);
    upload(w_.vertex_triangle_neighbours, topology.vertex_triangle_neighbours);
    upload(w_.edge_edge_neighbours, topology.edge_edge_neighbours);
    counts_ = {topology.triangles.size(), topology.vertex_triangle_neighbours.size(),
               topology.edge_edge_neighbours.size()};
    scene_.triangle_count = static_cast<std::uint32_t>(topology.triangles.size());
    scene_.edge_count = static_cast<std::uint32_t>(topology.edges.size());
    scene_.vertex_count = static_cast<std::uint32_t>(topology.vertex_body.size());
    chunks_ = 1;
    backend_.reserve_positions(w_.x_t0, w_.x_t1, scene_.vertex_count);
  }

  PositionArrays position_arrays() override { return backend_.position_arrays(w_.x_t0, w_.x_t1); }

  void start(const SceneBodies& bodies, const DetectionSettings& settings) override {
    if (settings.memory_limit != settings_.memory_limit) chunks_ = 1;
    settings_ = settings;
    backend_.start_clock();
    backend_.set_memory_limit(settings.memory_limit);
    upload(w_.bodies, bodies.bodies);
    upload(w_.may_touch, bodies.may_touch);
    view_scene(bodies);
    backend_.upload_positions(w_.x_t0, w_.x_t1, scene_.vertex_count, settings.both_ends);
    split_until([this] {
      reserve_lists();
      launch();
    });
  }

  Span<const Contact> finish(Statistics& statistics) override {
    Counters counters{};
    bool is_complete = false;
    bool has_to_launch = false;
    while (!is_complete) {
      const std::uint32_t chunks = chunks_;
      split_until([&] {
        if (has_to_launch || chunks_ != chunks) launch();
        has_to_launch = true;
        counters = read_counters();
        is_complete = !with_lists([&](auto&... lists) { return grow_lists(backend_, counters, lists...); });
      });
      if (!is_complete) backend_.count_rerun();
    }
    if (!Backend::kKnowsCounts) {
      with_lists([&](auto&... lists) { fit_lists(counters, lists...); });
    }
    const Span<const Contact> contacts = backend_.contacts(counters.contacts);
    report(counters, contacts, statistics);
    return contacts;
  }

 private:
  template <class Buffer, class T>
  void upload(Buffer& buffer, Span<const T> values) {
    buffer.reserve(backend_, values.size(), 0);
    backend_.upload(buffer, values);
  }

  void view_scene(const SceneBodies& bodies) {
    const bool continuous = settings_.detection == Detection::ccd;
    scene_.x_t0 = settings_.both_ends ? w_.x_t0.data() : w_.x_t1.data();
    scene_.x_t1 = w_.x_t1.data();
    scene_.triangles = w_.triangles.data();
    scene_.triangle_edges = w_.triangle_edges.data();
    scene_.edges = w_.edges.data();
    scene_.ownership = w_.ownership.data();
    scene_.triangle_body = w_.triangle_body.data();
    scene_.vertex_body = w_.vertex_body.data();
    scene_.bodies = w_.bodies.data();
    scene_.may_touch = w_.may_touch.data();
    scene_.pair_words = bodies.pair_words;
    scene_.body_count = static_cast<std::uint32_t>(bodies.bodies.size());
    scene_.summarize_pairs(bodies.may_touch);
    scene_.is_swept = continuous && settings_.both_ends;
    scene_.motion_margin = continuous ? 0.0F : settings_.motion_margin;
    scene_.is_conservative = settings_.accuracy == Accuracy::conservative;
    scene_.contact_rule = continuous ? ContactRule::distance : settings_.contact_rule;
  }

  /// Runs f; as long as memory does not suffice, again with twice as many chunks.
  template <class F>
  void split_until(const F& f) {
    for (;;) {
      try {
        f();
        return;
      } catch (const ChunkTooLarge&) {
        if (chunks_ >= kMostChunks) throw std::bad_alloc();
      } catch (const std::bad_alloc&) {
        if (chunks_ >= kMostChunks || chunk_bytes() < backend_.bytes() / 64) throw;
      }
      // One of these lists may have taken what another one needs.
      w_.pairs.release(backend_);
      w_.vt_candidates.release(backend_);
      w_.ee_candidates.release(backend_);
      chunks_ *= 2;
      backend_.count_rerun();
    }
  }

  std::uint64_t chunk_bytes() const { return w_.pairs.bytes() + w_.vt_candidates.bytes() + w_.ee_candidates.bytes(); }

  /// As if the lists of the largest chunk had been the last one's.
  Counters read_counters() {
    Counters counters = backend_.finish();
    total_ = {counters.done.pairs + counters.pairs, counters.done.vt_candidates + counters.vt_candidates,
              counters.done.ee_candidates + counters.ee_candidates};
    counters.pairs = std::max(counters.pairs, counters.most.pairs);
    counters.vt_candidates = std::max(counters.vt_candidates, counters.most.vt_candidates);
    counters.ee_candidates = std::max(counters.ee_candidates, counters.most.ee_candidates);
    return counters;
  }

  /// First guesses, so that an ordinary first detection need not repeat a stage. None where memory is limited.
  void reserve_lists() {
    const std::uint64_t triangles = scene_.triangle_count;
    w_.counters.reserve(backend_, 1, 0);
    if (guessed_for_ == triangles || settings_.memory_limit > 0) return;
    guessed_for_ = triangles;
    w_.entries.reserve(backend_, 6 * triangles, 0);
    w_.pairs.reserve(backend_, 8 * triangles, 0);
    if (settings_.vertex_triangle) w_.vt_candidates.reserve(backend_, 8 * triangles, 0);
    if (settings_.edge_edge) w_.ee_candidates.reserve(backend_, 16 * triangles, 0);
    w_.found.reserve(backend_, 4 * triangles, 0);
  }

  void detect() {
    with_lists([](auto&... lists) { (lists.rewind(), ...); });
    w_.contact_keys.rewind();
    w_.contact_order.rewind();
    backend_.run_once("clear_counters", ClearCounters{w_.counters.data(), counts_});
    BroadPhaseStages<Backend> broad_phase(backend_, w_, scene_, settings_);
    NarrowPhaseStages<Backend> narrow_phase(backend_, w_, scene_, settings_, counts_);
    broad_phase.prepare();
    for (std::uint32_t chunk = 0; chunk + 1 < chunks_; ++chunk) {
      broad_phase.test_pairs({chunk, chunks_});
      narrow_phase.find_contacts();
      backend_.run_once("next_chunk", NextChunk{w_.counters.data()});
    }
    broad_phase.test_pairs({chunks_ - 1, chunks_});
    broad_phase.add_remaining_pairs();
    narrow_phase.test_neighbours();
    narrow_phase.find_contacts();
    narrow_phase.sort_contacts();
    backend_.begin(Stage::transfer);
    backend_.download(w_.counters, w_.contacts, w_.found.count(w_.counters.data()));
  }

  /// Everything that decides which work detect() enqueues. Two detections with the same signature enqueue the same work
  /// on the same memory.
  std::vector<std::uint64_t> signature() {
    std::uint32_t lambda_bits = 0;
    std::uint32_t motion_bits = 0;
    std::memcpy(&lambda_bits, &settings_.lambda, sizeof(lambda_bits));
    std::memcpy(&motion_bits, &scene_.motion_margin, sizeof(motion_bits));
    std::vector<std::uint64_t> values = {static_cast<std::uint64_t>(settings_.detection),
                                         static_cast<std::uint64_t>(settings_.accuracy),
                                         static_cast<std::uint64_t>(settings_.broad_phase),
                                         settings_.subdivision,
                                         static_cast<std::uint64_t>(scene_.contact_rule),
                                         settings_.vertex_triangle,
                                         settings_.edge_edge,
                                         settings_.both_ends,
                                         lambda_bits,
                                         motion_bits,
                                         scene_.triangle_count,
                                         scene_.vertex_count,
                                         scene_.edge_count,
                                         counts_.vertex_triangle_neighbours,
                                         counts_.edge_edge_neighbours,
                                         scene_.body_count,
                                         scene_.pair_words,
                                         scene_.self_collision,
                                         chunks_};
    values.insert(values.end(), scene_.class_may_touch, scene_.class_may_touch + kBodyClasses);
    with_lists([&](auto&... lists) { (values.push_back(lists.capacity()), ...); });
    return values;
  }

  void launch() {
    backend_.launch(signature(), [this] { detect(); });
  }

  /// Calls f with every list.
  template <class F>
  decltype(auto) with_lists(const F& f) {
    return f(w_.bigs, w_.splits, w_.split_words, w_.split_cells, w_.entries, w_.flagged, w_.pairs, w_.vt_candidates,
             w_.ee_candidates, w_.found);
  }

  void report(const Counters& counters, Span<const Contact> contacts, Statistics& statistics) const {
    const auto* first_edge_contact = std::partition_point(contacts.begin(), contacts.end(), [](const Contact& contact) {
      return contact.kind == ContactKind::vertex_triangle;
    });
    statistics.active_triangles = counters.grid.active_triangles;
    statistics.mean_radius = static_cast<double>(counters.grid.mean_radius);
    statistics.cell_size = static_cast<double>(counters.grid.cell_size);
    statistics.split_triangles = counters.splits;
    statistics.children = counters.children;
    statistics.big_triangles = counters.bigs;
    statistics.entries = counters.entries;
    statistics.cells = counters.cells;
    statistics.tests = counters.tests + counters.bigs * counters.grid.active_triangles;
    statistics.triangle_pairs = total_.pairs;
    statistics.flagged_pairs = counters.flagged;
    statistics.vt_candidates = total_.vt_candidates;
    statistics.ee_candidates = total_.ee_candidates;
    statistics.vt_contacts = static_cast<std::uint64_t>(first_edge_contact - contacts.begin());
    statistics.ee_contacts = static_cast<std::uint64_t>(contacts.end() - first_edge_contact);
    statistics.unsettled_contacts = counters.unsettled;
    statistics.earliest_toi = static_cast<double>(counters.earliest_toi);
    statistics.peak_bytes = backend_.peak_bytes();
    statistics.reruns = backend_.reruns();
    statistics.chunks = chunks_;
    statistics.ms = backend_.times();
  }

  Workspace<Backend> w_;
  SceneView scene_;
  SceneCounts counts_{};
  DetectionSettings settings_{};
  std::uint64_t guessed_for_ = 0;  ///< triangles that reserve_lists guessed for
  std::uint32_t chunks_ = 1;       ///< parts that the pair tests are made in
  ChunkCounts total_{};            ///< of the last detection
  Backend backend_;                ///< the last, so that it goes first: it waits for work that uses all the others
};

}  // namespace softcd

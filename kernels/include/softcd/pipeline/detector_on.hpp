#pragma once

#include <algorithm>
#include <cstring>
#include <vector>

#include "softcd/pipeline/broad_phase.inl"
#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/memory_account.hpp"
#include "softcd/pipeline/narrow_phase.inl"
#include "softcd/pipeline/workspace.hpp"

namespace softcd {

/// The detector on one backend. A backend provides (see cpu/cpu_backend.hpp, the shorter one, for the signatures):
/// Buffer and SortBuffer, which own memory that grows; run_once, for_each, for_each_append, for_each_work,
/// for_each_part and the `filtered` forms of the last two, exclusive_scan, sort_keys, sort_pairs, histogram and
/// minimum, which enqueue work in order; upload and download; launch, which runs a callable that enqueues and may
/// return early; finish, which waits; begin, which starts the clock of a part; give_scratch_back, for what is in no
/// buffer.
template <class Backend>
class DetectorOn final : public Detector {
  static constexpr std::uint64_t kMostChunks = 4096;
  /// Where memory is short and counts are known at once chunks have no more tests than this, some 20 milliseconds'
  /// worth: what they lead to is known before they are all made.
  static constexpr std::uint64_t kMostTestsOfChunk = 1ULL << 22;

 public:
  template <class... Arguments>
  explicit DetectorOn(Arguments... arguments) : backend_(account_, arguments...) {}

  bool set_memory_limit(std::uint64_t bytes) override {
    if (bytes == account_.limit()) return true;
    const auto is_exceeded = [&] { return bytes > 0 && account_.bytes() > bytes; };
    if (is_exceeded()) release_lists();
    const bool keeps_topology = !is_exceeded();
    if (!keeps_topology) memory_ = {};
    account_.set_limit(bytes);
    chunks_ = 1;
    return keeps_topology;
  }

  void set_topology(const SceneTopology& topology) override {
    with_lists_or_without([&] { upload_topology(topology); });
    counts_ = {topology.triangles.size(), topology.vertex_triangle_neighbours.size(),
               topology.edge_edge_neighbours.size()};
    scene_.triangle_count = static_cast<std::uint32_t>(topology.triangles.size());
    scene_.edge_count = static_cast<std::uint32_t>(topology.edges.size());
    scene_.vertex_count = static_cast<std::uint32_t>(topology.vertex_body.size());
    chunks_ = 1;
  }

  PositionArrays position_arrays() override { return backend_.position_arrays(memory_.x_t0, memory_.x_t1); }

  void start(const SceneBodies& bodies, const DetectionSettings& settings) override {
    settings_ = settings;
    backend_.start_clock();
    account_.forget_refusals();
    reached_ = {};
    has_released_ = false;
    first_chunk_ = 0;
    with_lists_or_without([&] {
      upload(memory_.bodies, bodies.bodies);
      upload(memory_.partner_begin, bodies.partner_begin);
      const std::uint64_t partners = bodies.partners.size();
      if (partners > memory_.partners.capacity()) memory_.partners.reserve(backend_, partners + partners / 4, 0);
      upload(memory_.partners, bodies.partners);
    });
    view_scene(bodies);
    backend_.upload_positions(memory_.x_t0, memory_.x_t1, scene_.vertex_count, settings.both_ends);
    guess_lists();
    is_launched_ = attempt([&] { launch(); });
  }

  Span<const Contact> finish(Statistics& statistics) override {
    Counters counters{};
    bool is_complete = false;
    while (!is_complete) {
      attempt([&] {
        if (!std::exchange(is_launched_, false)) launch();
        counters = read_counters();
        is_complete = !with_lists([&](auto&... lists) { return grow_lists(backend_, counters, lists...); });
        if (!is_complete) backend_.count_rerun();
      });
    }
    if (!Backend::kKnowsCounts) {
      with_lists([&](auto&... lists) { fit_lists(counters, lists...); });
    }
    const Span<const Contact> contacts = backend_.contacts(counters.contacts);
    report(counters, contacts, statistics);
    return contacts;
  }

  void report_memory(Statistics& statistics) const override {
    statistics.peak_bytes = account_.peak_bytes();
    statistics.reruns = backend_.reruns();
    statistics.chunks = chunks_;
  }

 private:
  template <class Buffer, class T>
  void upload(Buffer& buffer, Span<const T> values) {
    buffer.reserve(backend_, values.size(), 0);
    backend_.upload(buffer, values);
  }

  void upload_topology(const SceneTopology& topology) {
    upload(memory_.triangles, topology.triangles);
    upload(memory_.triangle_edges, topology.triangle_edges);
    upload(memory_.edges, topology.edges);
    upload(memory_.ownership, topology.ownership);
    upload(memory_.triangle_body, topology.triangle_body);
    upload(memory_.vertex_body, topology.vertex_body);
    upload(memory_.vertex_triangle_neighbours, topology.vertex_triangle_neighbours);
    upload(memory_.edge_edge_neighbours, topology.edge_edge_neighbours);
    backend_.reserve_positions(memory_.x_t0, memory_.x_t1, topology.vertex_body.size());
  }

  void view_scene(const SceneBodies& bodies) {
    const bool continuous = settings_.detection == Detection::ccd;
    scene_.x_t0 = settings_.both_ends ? memory_.x_t0.data() : memory_.x_t1.data();
    scene_.x_t1 = memory_.x_t1.data();
    scene_.triangles = memory_.triangles.data();
    scene_.triangle_edges = memory_.triangle_edges.data();
    scene_.edges = memory_.edges.data();
    scene_.ownership = memory_.ownership.data();
    scene_.triangle_body = memory_.triangle_body.data();
    scene_.vertex_body = memory_.vertex_body.data();
    scene_.bodies = memory_.bodies.data();
    scene_.partner_begin = memory_.partner_begin.data();
    scene_.partners = memory_.partners.data();
    scene_.body_count = static_cast<std::uint32_t>(bodies.bodies.size());
    scene_.summarize_pairs(bodies.partner_begin, bodies.partners);
    scene_.is_swept = continuous && settings_.both_ends;
    scene_.motion_margin = continuous ? 0.0F : settings_.motion_margin;
    scene_.is_conservative = settings_.accuracy == Accuracy::conservative;
    scene_.contact_rule = continuous ? ContactRule::distance : settings_.contact_rule;
  }

  /// Everything but the scene.
  void release_lists() {
    backend_.give_scratch_back();
    w_ = {};
  }

  /// Runs f, which takes memory for the scene; again without the lists when it does not suffice.
  template <class F>
  void with_lists_or_without(const F& f) {
    try {
      f();
    } catch (const std::bad_alloc&) {
      release_lists();
      f();
    }
  }

  /// First guesses, so that an ordinary first detection need not repeat a stage. None where memory is limited, or does
  /// not suffice.
  void guess_lists() {
    const std::uint64_t triangles = scene_.triangle_count;
    if (guessed_for_ == triangles || account_.is_limited()) return;
    guessed_for_ = triangles;
    try {
      w_.entries.reserve(backend_, 6 * triangles, 0);
      w_.pairs.reserve(backend_, 8 * triangles, 0);
      if (settings_.vertex_triangle) w_.vt_candidates.reserve(backend_, 8 * triangles, 0);
      if (settings_.edge_edge) w_.ee_candidates.reserve(backend_, 16 * triangles, 0);
      w_.found.reserve(backend_, 4 * triangles, 0);
    } catch (const std::bad_alloc&) {
      release_lists();
    }
  }

  /// Whether f succeeds. When memory does not suffice there is more for the next attempt. Throws std::bad_alloc when no
  /// further one can succeed.
  template <class F>
  bool attempt(const F& f) {
    try {
      f();
      return true;
    } catch (const std::bad_alloc&) {
    }
    try {
      make_room();
    } catch (const std::bad_alloc&) {
      release_lists();
      throw;
    }
    backend_.count_rerun();
    return false;
  }

  /// Gives all lists back, takes what contacts, and whatever else more chunks cannot make smaller, are known to need,
  /// and divides chunks so that theirs should fit into half of what is left. Throws std::bad_alloc when that is
  /// nothing.
  void make_room() {
    const Counters reached = counters_reached();
    release_lists();
    const std::uint64_t chunk_bytes = bytes_of_chunk(reached);
    if (chunk_bytes == 0 && std::exchange(has_released_, true)) throw std::bad_alloc();
    with_whole_lists([&](auto&... lists) { (lists.reserve(backend_, reached.*lists.counter(), 0), ...); });
    w_.reserve_sorted_contacts(backend_, reached.contacts);
    if (chunk_bytes == 0) return;
    if (chunks_ == kMostChunks) throw std::bad_alloc();
    const std::uint64_t room = (account_.available() - std::min(account_.available(), account_.bytes())) / 2;
    const std::uint64_t parts = chunk_bytes / std::max<std::uint64_t>(room, 1) + 1;
    const std::uint64_t failed_chunk = chunk_ * kMostChunks / chunks_;
    chunks_ = std::min(kMostChunks, chunks_ * std::clamp<std::uint64_t>(parts, 2, kMostChunks));
    if (Backend::kKnowsCounts) first_chunk_ = static_cast<std::uint32_t>(failed_chunk * chunks_ / kMostChunks);
  }

  /// What the lists of the largest chunk need. Candidates that were not looked for yet are as many as there can be.
  std::uint64_t bytes_of_chunk(const Counters& reached) const {
    const std::uint64_t pairs = std::max(reached.pairs, reached.most.pairs);
    std::uint64_t vt_candidates = std::max(reached.vt_candidates, reached.most.vt_candidates);
    std::uint64_t ee_candidates = std::max(reached.ee_candidates, reached.most.ee_candidates);
    if (vt_candidates == 0 && settings_.vertex_triangle) vt_candidates = 6 * pairs;
    if (ee_candidates == 0 && settings_.edge_edge) ee_candidates = 9 * pairs;
    return (pairs + vt_candidates + ee_candidates) * sizeof(std::uint64_t);
  }

  /// Of the attempt that failed, as far as they are known. Those of lists that overflowed count what they lacked too.
  Counters counters_reached() {
    if constexpr (Backend::kKnowsCounts) {
      if (w_.counters.capacity() > 0) return *w_.counters.data();
    }
    return reached_;
  }

  /// As if the lists of the largest chunk had been the last one's.
  Counters read_counters() {
    Counters counters = backend_.finish();
    total_ = {counters.done.pairs + counters.pairs, counters.done.vt_candidates + counters.vt_candidates,
              counters.done.ee_candidates + counters.ee_candidates};
    counters.pairs = std::max(counters.pairs, counters.most.pairs);
    counters.vt_candidates = std::max(counters.vt_candidates, counters.most.vt_candidates);
    counters.ee_candidates = std::max(counters.ee_candidates, counters.most.ee_candidates);
    reached_ = counters;
    return counters;
  }

  void detect() {
    with_lists([](auto&... lists) { (lists.rewind(), ...); });
    w_.contact_keys.rewind();
    w_.contact_order.rewind();
    backend_.run_once("clear_counters", ClearCounters{w_.counters.data(), counts_});
    BroadPhaseStages<Backend> broad_phase(backend_, w_, scene_, settings_);
    NarrowPhaseStages<Backend> narrow_phase(backend_, memory_, w_, scene_, settings_, counts_);
    broad_phase.prepare();
    if (Backend::kKnowsCounts && (account_.is_limited() || chunks_ > 1)) {
      const std::uint64_t least_chunks = w_.counters.data()->tests / kMostTestsOfChunk + 1;
      chunks_ = std::max(chunks_, std::min(kMostChunks, least_chunks));
    }
    const auto chunks = static_cast<std::uint32_t>(chunks_);
    for (std::uint32_t i = 0; i < chunks; ++i) {
      if (i > 0) {
        narrow_phase.find_contacts();
        backend_.run_once("next_chunk", NextChunk{w_.counters.data()});
      }
      chunk_ = (first_chunk_ + i) % chunks;
      broad_phase.test_pairs({chunk_, chunks});
    }
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
                                         scene_.self_collision,
                                         chunks_};
    values.insert(values.end(), scene_.class_may_touch, scene_.class_may_touch + kBodyClasses);
    with_lists([&](auto&... lists) { (values.push_back(lists.capacity()), ...); });
    return values;
  }

  void launch() {
    w_.counters.reserve(backend_, 1, 0);
    if constexpr (Backend::kKnowsCounts) *w_.counters.data() = {};
    backend_.launch(signature(), [this] { detect(); });
  }

  /// Calls f with every list.
  template <class F>
  decltype(auto) with_lists(const F& f) {
    return with_whole_lists([&](auto&... whole) { return f(whole..., w_.pairs, w_.vt_candidates, w_.ee_candidates); });
  }

  /// Those that are of the whole detection, not of one chunk.
  template <class F>
  decltype(auto) with_whole_lists(const F& f) {
    return f(w_.bigs, w_.splits, w_.split_words, w_.split_cells, w_.entries, w_.flagged, w_.found);
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
    report_memory(statistics);
    statistics.ms = backend_.times();
  }

  MemoryAccount account_;
  SceneMemory<Backend> memory_;
  Workspace<Backend> w_;
  SceneView scene_;
  SceneCounts counts_{};
  DetectionSettings settings_{};
  std::uint64_t guessed_for_ = 0;  ///< triangles that guess_lists guessed for
  std::uint64_t chunks_ = 1;       ///< parts that the pair tests are made in
  std::uint32_t chunk_ = 0;        ///< the one that is worked on, or was when memory ran out
  std::uint32_t first_chunk_ = 0;  ///< to be worked on: what did not fit before shows at once whether it does now
  Counters reached_{};             ///< by the detection's last attempt that was finished; 0 at its start
  bool has_released_ = false;      ///< the detection's lists have only what it needs itself
  bool is_launched_ = false;
  ChunkCounts total_{};  ///< of the last detection
  Backend backend_;      ///< the last, so that it goes first: it waits for work that uses all the others
};

}  // namespace softcd

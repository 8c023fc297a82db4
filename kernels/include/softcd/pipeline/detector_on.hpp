#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <utility>

#include "softcd/pipeline/backend.hpp"
#include "softcd/pipeline/broad_phase.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/memory_account.hpp"
#include "softcd/pipeline/narrow_phase.hpp"
#include "softcd/pipeline/pair_keeping.hpp"
#include "softcd/pipeline/spatial_queries_on.hpp"
#include "softcd/pipeline/staying_contacts.hpp"
#include "softcd/pipeline/workspace.hpp"

namespace softcd {

/// A query's memory on a backend. `session` is the last member, so that it is destroyed first: its work may still use
/// the others.
template <class Backend>
struct QueryOn final : QueryMemory {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;

  explicit QueryOn(std::shared_ptr<MemoryAccount> its_account) : account(std::move(its_account)) {}

  void release() override {
    bodies_number = 0;
    bodies = {};
    partner_begin = {};
    partners = {};
    contacts = {};
    body_begin = {};
    contact_counts = {};
  }

  std::shared_ptr<MemoryAccount> account;  ///< of the buffers
  std::uint64_t bodies_number = 0;         ///< SceneBodies::number of what the next three hold
  Buffer<SceneBody> bodies;
  Buffer<std::uint64_t> partner_begin;
  Buffer<std::uint32_t> partners;
  Buffer<Contact> contacts;
  // Only if contacts stay on the backend; see DeviceContacts and PendingContacts:
  Buffer<std::uint64_t> body_begin;
  Buffer<ContactCounts> contact_counts;
  std::array<std::uint64_t, kListCount> capacities{};  ///< of the lists, after the last detection
  std::uint64_t guessed_for = 0;                       ///< triangles that the first capacities were guessed for
  std::uint64_t chunks = 1;                            ///< parts that the last detection's pair tests were made in
  std::uint64_t revision = 0;                          ///< the detector's, during the last detection
  bool orders_in_runs = true;                          ///< until some were too long
  bool lays_into_bins = true;                          ///< until some were too long
  ChunkCounts total{};                                 ///< of the last detection
  std::shared_ptr<Usefulness> usefulness = std::make_shared<Usefulness>();  ///< of what its detections keep
  typename Backend::Session session;
};

/// The detector on one backend. Another `Scheme` is in benchmarks/paper.
template <DetectionBackend Backend, class Scheme = ExactScheme>
class DetectorOn final : public Detector {
  using Wanted = typename BroadPhaseStages<Backend, Scheme>::Wanted;

  static constexpr std::uint64_t kMostChunks = 4096;
  /// Most tests of a chunk if memory is short and counts are known at once: about 20 milliseconds of work. So the first
  /// chunks show what tests lead to before all are made.
  static constexpr std::uint64_t kMostTestsOfChunk = 1ULL << 22;
  /// Memory of one contact: as found, as given to the user, and twice its key and place, which are sorted.
  static constexpr std::uint64_t kBytesOfContact =
      sizeof(FeatureContact) + sizeof(Contact) + 2 * (sizeof(std::uint64_t) + sizeof(std::uint32_t));

 public:
  template <class... Arguments>
  explicit DetectorOn(Arguments... arguments)
      : account_(std::make_shared<MemoryAccount>()), backend_(*account_, arguments...) {}

  bool set_memory_limit(std::uint64_t bytes, QueryMemory& query) override {
    if (bytes == account_->limit()) return true;
    const auto is_exceeded = [&] { return bytes > 0 && account_->bytes() > bytes; };
    if (is_exceeded()) release_lists();
    if (is_exceeded()) query.release();
    const bool keeps_scene = !is_exceeded();
    if (!keeps_scene) mirror_ = {};
    account_->set_limit(bytes);
    ++revision_;
    return keeps_scene;
  }

  void set_scene(const SceneArrays& scene, const SceneChanges& changes) override {
    needs_ = MemoryNeed::For::scene;
    verdict_ = changes.verdict;
    with_lists_or_without([&] { follow(scene, changes); });
    counts_ = {scene.triangles.size(), scene.vertex_triangle_neighbours.size(), scene.edge_edge_neighbours.size(),
               scene.stars.size()};
    scene_.triangle_count = static_cast<std::uint32_t>(scene.triangles.size());
    scene_.edge_count = static_cast<std::uint32_t>(scene.edges.size());
    scene_.vertex_count = static_cast<std::uint32_t>(scene.vertex_body.size());
    patch_count_ = static_cast<std::uint32_t>(scene.patch_triangles.size() / kPatchSize);
    if (std::exchange(scene_revision_, scene.revision) != scene.revision) ++revision_;
  }

  std::unique_ptr<QueryMemory> make_query() override { return std::make_unique<QueryOn<Backend>>(account_); }

  void start(QueryMemory& query, const SceneBodies& bodies, const DetectionSettings& settings) override {
    query_ = &static_cast<QueryOn<Backend>&>(query);
    settings_ = settings;
    backend_.begin_detection(query_->session);
    account_->forget_refusals();
    reached_ = {};
    has_released_ = false;
    has_reused_ = false;
    first_chunk_ = 0;
    chunks_ = query_->revision == revision_ ? query_->chunks : 1;
    query_->orders_in_runs |= query_->revision != revision_;
    query_->lays_into_bins |= query_->revision != revision_;
    may_keep_ = settings.reuses_pairs && chunks_ == 1 && !account_->is_limited() && settings.partition.is_whole();
    given_bodies_ = bodies;
    body_ids_ = settings.contacts_stay && !bodies.bodies.empty() ? bodies.bodies[bodies.bodies.size() - 1].id + 1 : 0;
    is_all_enqueued_ = false;
    if (bodies.number == 0 || bodies.number != query_->bodies_number) {
      query_->bodies_number = 0;
      with_lists_or_without([&] { upload_bodies(bodies); });
      query_->bodies_number = bodies.number;
    }
    needs_ = MemoryNeed::For::lists;
    found_ = 0;
    view_scene(bodies);
    restore_capacities();
    guess_lists();
    is_launched_ = attempt([&] { launch(); });
  }

  StayingContacts staying() const override {
    if (!is_all_enqueued_) return {};
    return {query_->contacts.data(),
            w_.lists.found.capacity(),
            query_->contact_counts.data(),
            query_->body_begin.data(),
            body_ids_,
            ready_};
  }

  Span<const Contact> finish(Statistics& statistics) override {
    Counters counters{};
    bool is_complete = false;
    while (!is_complete) {
      attempt([&] {
        if (!std::exchange(is_launched_, false)) launch();
        counters = read_counters();
        is_complete = !w_.lists.with_all([&](auto&... lists) { return grow_lists(backend_, counters, lists...); });
        if (may_keep_ && grow_lists(backend_, counters, w_.kept.pairs)) is_complete = false;
        const bool has_long_runs = query_->orders_in_runs && counters.long_runs > 0;
        if (has_long_runs) query_->orders_in_runs = false;
        if (!Backend::kKnowsCounts && has_long_runs) is_complete = false;
        if (counters.long_bins > 0) is_complete = query_->lays_into_bins = false;
        if (is_complete) return;
        if (may_keep_ && !has_reused_) keeping_->drop();
        may_keep_ = has_reused_;
        backend_.count_rerun();
      });
    }
    if (counters.all == 0) {  // nothing was detected, and nothing is learnt
      may_keep_ = false;
      is_all_enqueued_ = true;
      backend_.contacts(0);
      statistics.ms = backend_.times();
      return {};
    }
    if (!has_reused_) {
      w_.kept.has_split = counters.splits > 0;
      if (may_keep_) keeping_->conclude(counters);
    }
    w_.lists.with_all([&](auto&... lists) {
      if (!Backend::kKnowsCounts && !has_reused_) fit_lists(counters, lists...);
      query_->capacities = {lists.capacity()...};
    });
    is_all_enqueued_ = true;
    query_->chunks = chunks_;
    query_->revision = revision_;
    const Span<const Contact> contacts = backend_.contacts(counters.contacts);
    report(counters, contacts, statistics);
    test_samples_.tests = counters.tests;
    std::copy(std::begin(counters.test_samples), std::end(counters.test_samples), test_samples_.cells);
    return contacts;
  }

  std::unique_ptr<QueryMemory> make_probe() override { return std::make_unique<ProbeOn<Backend>>(account_); }

  void answer(QueryMemory& memory, const ProbedScene& scene, const Questions& ask) override {
    auto& probe = static_cast<ProbeOn<Backend>&>(memory);
    account_->forget_refusals();
    with_lists_or_without([&] {
      upload(probe.bodies, scene.bodies);
      SpatialQueriesOn<Backend> queries(backend_, probe, probed_view(scene, probe));
      ask(queries);
    });
  }

  void report_memory(Statistics& statistics) const override {
    statistics.peak_bytes = account_->peak_bytes();
    statistics.reruns = backend_.reruns();
    statistics.chunks = chunks_;
  }

  MemoryNeed memory_need() const override {
    const std::uint64_t bytes = account_->refused_total();
    const bool are_contacts = needs_ == MemoryNeed::For::lists && found_ * kBytesOfContact > bytes / 2;
    return {are_contacts ? MemoryNeed::For::contacts : needs_, bytes, found_};
  }

  TestSamples test_samples() const override { return test_samples_; }

 private:
  template <class Buffer, class T>
  void upload(Buffer& buffer, Span<const T> values) {
    buffer.reserve(backend_, values.size(), 0);
    backend_.upload(buffer, values);
  }

  void upload_bodies(const SceneBodies& bodies) {
    upload(query_->bodies, bodies.bodies);
    upload(query_->partner_begin, bodies.partner_begin);
    const std::uint64_t partners = bodies.partners.size();
    if (partners > query_->partners.capacity()) query_->partners.reserve(backend_, partners + partners / 4, 0);
    upload(query_->partners, bodies.partners);
  }

  void follow(const SceneArrays& scene, const SceneChanges& changes) {
    mirror_.triangles.follow(backend_, scene.triangles, changes.triangles);
    mirror_.triangle_edges.follow(backend_, scene.triangle_edges, changes.triangles);
    mirror_.ownership.follow(backend_, scene.ownership, changes.triangles);
    if constexpr (Backend::kHasPatches) {
      mirror_.patch_triangles.follow(backend_, scene.patch_triangles, changes.patches);
    }
    mirror_.ownership.follow(backend_, scene.ownership, changes.ownership);
    mirror_.triangle_body.follow(backend_, scene.triangle_body, changes.triangles);
    mirror_.edges.follow(backend_, scene.edges, changes.edges);
    mirror_.vertex_body.follow(backend_, scene.vertex_body, changes.vertices);
    mirror_.x_t0.follow(backend_, scene.x_t0, changes.x_t0);
    mirror_.x_t1.follow(backend_, scene.x_t1, changes.x_t1);
    mirror_.full_t0.follow(backend_, scene.full_t0, changes.full_t0);
    mirror_.full_t1.follow(backend_, scene.full_t1, changes.full_t1);
    if constexpr (!Backend::kKnowsCounts) {
      if (verdict_.known != nullptr) backend_.wait_for(verdict_.known);
      mirror_.x_t0.place(backend_, changes.device_x_t0, changes.origin);
      mirror_.x_t1.place(backend_, changes.device_x_t1, changes.origin);
      mirror_.full_t0.place(backend_, changes.device_full_t0, changes.origin);
      mirror_.full_t1.place(backend_, changes.device_full_t1, changes.origin);
    }
    mirror_.vertex_triangle_neighbours.follow(backend_, scene.vertex_triangle_neighbours,
                                              changes.vertex_triangle_neighbours);
    mirror_.edge_edge_neighbours.follow(backend_, scene.edge_edge_neighbours, changes.edge_edge_neighbours);
    mirror_.stars.follow(backend_, scene.stars, changes.stars);
    const FilterArrays& filters = scene.filters;
    scene_.filters = {followed(mirror_.vertex_filters, filters.vertices, changes.filters),
                      followed(mirror_.ring_begin, filters.ring_begin, changes.filters),
                      followed(mirror_.ring_vertices, filters.ring_vertices, changes.filters),
                      followed(mirror_.x_rest, filters.x_rest, changes.filters)};
  }

  /// Returns the values in the backend's memory; null if there are none.
  template <class T>
  const T* followed(typename Backend::template Mirror<T>& mirror, Span<const T> values, bool have_changed) {
    const Range all = {0, have_changed ? values.size() : 0};
    mirror.follow(backend_, values, Span<const Range>(&all, 1));
    return values.empty() ? nullptr : mirror.data();
  }

  void view_scene(const SceneBodies& bodies) {
    const bool continuous = settings_.detection == Detection::ccd;
    scene_.x_t1 = settings_.at_t0 ? mirror_.x_t0.data() : mirror_.x_t1.data();
    scene_.x_t0 = settings_.both_ends ? mirror_.x_t0.data() : scene_.x_t1;
    view_full_positions();
    scene_.triangles = mirror_.triangles.data();
    scene_.triangle_edges = mirror_.triangle_edges.data();
    scene_.edges = mirror_.edges.data();
    scene_.ownership = mirror_.ownership.data();
    scene_.triangle_body = mirror_.triangle_body.data();
    scene_.patch_triangles = mirror_.patch_triangles.data();
    scene_.patch_count = has_patches() ? patch_count_ : 0;
    scene_.vertex_body = mirror_.vertex_body.data();
    scene_.bodies = query_->bodies.data();
    scene_.partner_begin = query_->partner_begin.data();
    scene_.partners = query_->partners.data();
    scene_.body_count = static_cast<std::uint32_t>(bodies.bodies.size());
    scene_.summarize_pairs(bodies.partner_begin, bodies.partners);
    scene_.has_batches = std::any_of(bodies.bodies.begin(), bodies.bodies.end(),
                                     [](const SceneBody& body) { return body.cell_offset != 0; });
    scene_.filters.are_set = scene_.filters.vertices != nullptr ||
                             std::any_of(bodies.bodies.begin(), bodies.bodies.end(), [](const SceneBody& body) {
                               return body.excludes_rings || body.rest_distance > 0.0F;
                             });
    scene_.is_swept = continuous && settings_.both_ends;
    scene_.motion_margin = continuous ? 0.0F : settings_.motion_margin;
    scene_.is_conservative = settings_.accuracy == Accuracy::conservative;
    scene_.contact_rule = continuous ? ContactRule::distance : settings_.contact_rule;
  }

  /// The uniform grid, which exists for comparison, has no patches.
  bool has_patches() const {
    return Backend::kHasPatches && Scheme::kMayHavePatches && settings_.broad_phase == softcd::BroadPhase::exact;
  }

  void view_full_positions() {
    scene_.full_t0 = scene_.full_t1 = nullptr;
    if (!settings_.covers_rounding) return;
    scene_.full_t1 = settings_.at_t0 ? mirror_.full_t0.data() : mirror_.full_t1.data();
    scene_.full_t0 = settings_.both_ends ? mirror_.full_t0.data() : scene_.full_t1;
  }

  /// Builds the hierarchy of the probed end of the step, unless it is up to date.
  ProbedSceneView probed_view(const ProbedScene& scene, const ProbeOn<Backend>& probe) {
    const Vec3f* const x = scene.at_t0 ? mirror_.x_t0.data() : mirror_.x_t1.data();
    Bvh<Backend>& bvh = bvhs_[scene.at_t0 ? 0 : 1];
    bvh.build(backend_,
              {x, mirror_.triangles.data(), mirror_.ownership.data(), mirror_.triangle_body.data(),
               scene_.triangle_count, scene.bounds},
              scene.revision);
    const Vec3d lo = vec3_cast<double>(scene.bounds.lo);
    const Vec3d hi = vec3_cast<double>(scene.bounds.hi);
    return {bvh.view(),
            probe.bodies.data(),
            mirror_.triangles.data(),
            mirror_.ownership.data(),
            x,
            mirror_.triangle_body.data(),
            scene.origin,
            0.5 * (lo + hi),
            0.5 * max_norm(hi - lo)};
  }

  /// All queries share the lists, but need different capacities.
  void restore_capacities() {
    w_.lists.with_all([&](auto&... lists) {
      std::size_t i = 0;
      (lists.restore_capacity(query_->capacities[i++]), ...);
    });
  }

  /// Releases everything but the scene and the queries' contacts.
  void release_lists() {
    backend_.give_scratch_back();
    w_ = {};
    bvhs_ = {};
  }

  /// Runs f, which takes memory for the scene. If memory does not suffice, releases the lists and runs f again.
  template <class F>
  void with_lists_or_without(const F& f) {
    try {
      f();
    } catch (const std::bad_alloc&) {
      release_lists();
      f();
    }
  }

  /// Guesses first capacities, so that an ordinary first detection need not repeat a stage. Guesses nothing if memory
  /// is limited or does not suffice. Small scenes get much, as it takes little memory. Large scenes get what a cloth on
  /// a ball needs, because memory that a first detection takes is kept. A scene that needs more repeats a stage once.
  void guess_lists() {
    constexpr std::uint64_t kOrdinaryScene = 1ULL << 18;
    const std::uint64_t triangles = scene_.triangle_count / settings_.partition.rank.count;
    if (query_->guessed_for == triangles || account_->is_limited()) return;
    query_->guessed_for = triangles;
    const std::uint64_t first = std::min(triangles, kOrdinaryScene);
    const std::uint64_t rest = triangles - first;
    Lists<Backend, Scheme>& lists = w_.lists;
    try {
      lists.entries.reserve(backend_, (6 * first + 4 * rest) / (has_patches() ? 4 : 1), 0);
      if (has_patches()) {
        lists.loose.reserve(backend_, triangles / 4, 0);
        lists.patch_pairs.reserve(backend_, 5 * first + 2 * rest, 0);
      }
      lists.pairs.reserve(backend_, 8 * first + 3 * rest, 0);
      if (settings_.vertex_triangle) lists.vt_candidates.reserve(backend_, 8 * first + rest, 0);
      if (settings_.edge_edge) lists.ee_candidates.reserve(backend_, 16 * first + 2 * rest, 0);
      lists.found.reserve(backend_, 4 * first + rest, 0);
    } catch (const std::bad_alloc&) {
      release_lists();
    }
  }

  /// Runs f and returns whether it succeeds. If memory runs out, prepares another attempt. Throws std::bad_alloc if no
  /// further attempt can succeed.
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
      query_->contacts = {};
      throw;
    }
    backend_.count_rerun();
    return false;
  }

  /// Releases all lists. Then reserves what is known to be needed for contacts, and for other lists that more chunks
  /// cannot make smaller. Divides the detection into so many chunks that the lists of one should fit into half of the
  /// remaining memory. Throws std::bad_alloc if that cannot help.
  void make_room() {
    may_keep_ = has_reused_ = false;
    const Counters reached = counters_reached();
    found_ = reached.contacts;
    release_lists();
    query_->contacts = {};
    const std::uint64_t chunk_bytes = bytes_of_chunk(reached);
    if (chunk_bytes == 0 && std::exchange(has_released_, true)) throw std::bad_alloc();
    w_.lists.with_all([&](auto&... lists) { (reserve_whole(lists, reached), ...); });
    reserve_sorted_contacts(reached.contacts);
    if (chunk_bytes == 0) return;
    if (chunks_ == kMostChunks) throw std::bad_alloc();
    const std::uint64_t room = (account_->available() - std::min(account_->available(), account_->bytes())) / 2;
    const std::uint64_t parts = chunk_bytes / std::max<std::uint64_t>(room, 1) + 1;
    const std::uint64_t failed_chunk = chunk_ * kMostChunks / chunks_;
    chunks_ = std::min(kMostChunks, chunks_ * std::clamp<std::uint64_t>(parts, 2, kMostChunks));
    if (Backend::kKnowsCounts) first_chunk_ = static_cast<std::uint32_t>(failed_chunk * chunks_ / kMostChunks);
  }

  /// Reserves a list of the whole detection, with nothing to spare. Leaves the list of a chunk alone.
  template <class List>
  void reserve_whole(List& list, const Counters& reached) {
    if constexpr (!List::kIsOfChunk) list.reserve_only(backend_, list.counted(reached));
  }

  void reserve_sorted_contacts(std::uint64_t count) {
    query_->contacts.reserve(backend_, count, 0);
    w_.contact_keys.reserve(backend_, count, 0);
    w_.contact_order.reserve(backend_, count, 0);
  }

  /// Returns the memory of the largest chunk's lists. Pairs and candidates that were not counted yet are estimated as
  /// the most that there can be.
  std::uint64_t bytes_of_chunk(const Counters& reached) const {
    ChunkCounts most = reached.chunk;
    for_each_count(KeepLargerCount{}, most, reached.most);
    if (most.pairs == 0) most.pairs = kPatchSize * kPatchSize * most.patch_pairs;
    if (most.vt_candidates == 0 && settings_.vertex_triangle) most.vt_candidates = 6 * most.pairs;
    if (most.ee_candidates == 0 && settings_.edge_edge) most.ee_candidates = 9 * most.pairs;
    return (most.patch_pairs + most.pairs + most.vt_candidates + most.ee_candidates) * sizeof(std::uint64_t);
  }

  /// Returns the counters of the failed attempt, as far as they are known. For lists that overflowed they include what
  /// did not fit.
  Counters counters_reached() {
    if constexpr (Backend::kKnowsCounts) {
      if (w_.counters.capacity() > 0) return *w_.counters.data();
    }
    return reached_;
  }

  /// Waits for the counters. Replaces the counts of the last chunk by the largest ones of any chunk.
  Counters read_counters() {
    Counters counters = backend_.finish();
    query_->total = counters.done;
    for_each_count(AddCount{}, query_->total, counters.chunk);
    for_each_count(KeepLargerCount{}, counters.chunk, counters.most);
    reached_ = counters;
    return counters;
  }

  using BroadPhase = BroadPhaseStages<Backend, Scheme>;
  using NarrowPhase = NarrowPhaseStages<Backend, Scheme>;

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
    backend_.run_once("clear_counters", ClearCounters{w_.counters.data(), counts_, verdict_.is_as_predicted});
    BroadPhase broad_phase(backend_, w_, scene_, settings_);
    broad_phase.bound_triangles();
    if (may_keep_) keeping_->enqueue_comparison(broad_phase);
  }

  /// Finds the contacts. The triangles must be bounded.
  void find_contacts() {
    BroadPhase broad_phase(backend_, w_, scene_, settings_);
    NarrowPhase narrow_phase(backend_, mirror_, w_, scene_, settings_, counts_);
    if (may_keep_ && !has_reused_) keeping_->enqueue_volumes(broad_phase);
    narrow_phase.reserve_neighbours();
    bool in_runs = false;
    const auto reserve_order = [&] {
      reserve_sorted_contacts(w_.lists.found.capacity());
      in_runs = query_->orders_in_runs && has_runs(narrow_phase);
    };
    if (!Backend::kKnowsCounts) reserve_order();
    const auto enqueue_pairs = [&] { find_pairs_or_reuse(broad_phase, narrow_phase); };
    const auto count_in_runs = [&] {
      if (!Backend::kKnowsCounts && in_runs) narrow_phase.count_in_runs();
    };
    if (Backend::kKnowsCounts || chunks_ > 1) {  // each chunk's candidates are counted anew
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
    narrow_phase.order_contacts(query_->contacts.data(), in_runs);
    backend_.begin(Stage::transfer);
    const Count found = w_.lists.found.count(w_.counters.data());
    if (settings_.contacts_stay) conclude_contacts(found);
    backend_.download(w_.counters, query_->contacts, found, !settings_.contacts_stay);
  }

  /// Prepares ranges of bodies and counts for callers that read contacts in the backend's memory.
  void conclude_contacts(Count found) {
    const std::uint64_t ranges = 2 * std::uint64_t{body_ids_} + 1;
    query_->body_begin.reserve(backend_, ranges, 0);
    query_->contact_counts.reserve(backend_, 1, 0);
    Counters* const counters = w_.counters.data();
    std::uint64_t* const body_begin = query_->body_begin.data();
    backend_.for_each("find_body_ranges", Count{&counters->all, ranges},
                      FindBodyRange{query_->contacts.data(), found, body_ids_, body_begin});
    const bool needs_short_runs = !Backend::kKnowsCounts && query_->orders_in_runs;
    w_.lists.with_all([&](auto&... lists) {
      backend_.run_once("conclude_contacts",
                        ConcludeContacts<kListCount + 1>{counters,
                                                         {lists.bound(counters)..., w_.kept.pairs.bound(counters)},
                                                         needs_short_runs,
                                                         body_begin + body_ids_,
                                                         query_->contact_counts.data()});
    });
  }

  /// Returns whether there is memory to order contacts in runs. Otherwise contacts are sorted by keys.
  template <class NarrowPhase>
  bool has_runs(NarrowPhase& narrow_phase) {
    if (account_->is_limited()) return false;
    try {
      narrow_phase.reserve_runs();
      return true;
    } catch (const std::bad_alloc&) {
      w_.run_counts = {};
      w_.run_begins = {};
      return false;
    }
  }

  /// Finds pairs among those that an earlier detection kept, if all possible ones are among them. Otherwise finds them
  /// anew.
  void find_pairs_or_reuse(BroadPhase& broad_phase, NarrowPhase& narrow_phase) {
    if (has_reused_) return keeping_->enqueue_reuse(broad_phase);
    bool has_found = false;
    if (may_keep_ && keeping_->work().keeps_pairs) {
      keeping_->with_kept_volumes([&] {
        broad_phase.prepare(Wanted::overlapping_volumes, keeping_->grows_volumes());
        has_found = keeping_->may_keep_pairs();
        if (has_found) keeping_->enqueue_pairs(broad_phase);
      });
      if (has_found) return;
    } else {
      broad_phase.prepare(Wanted::meeting_triangles, false);
    }
    if (Backend::kKnowsCounts && (account_->is_limited() || chunks_ > 1)) {
      const std::uint64_t least_chunks = w_.counters.data()->tests / kMostTestsOfChunk + 1;
      chunks_ = std::max(chunks_, std::min(kMostChunks, least_chunks));
    }
    find_pairs(broad_phase, narrow_phase);
  }

  /// Finds pairs in chunks, and the contacts of all chunks but the last.
  void find_pairs(BroadPhase& broad_phase, NarrowPhase& narrow_phase) {
    const auto chunks = static_cast<std::uint32_t>(chunks_);
    for (std::uint32_t i = 0; i < chunks; ++i) {
      if (i > 0) {
        broad_phase.expand_patch_pairs();
        narrow_phase.find_contacts();
        backend_.run_once("next_chunk", NextChunk{w_.counters.data()});
      }
      chunk_ = (first_chunk_ + i) % chunks;
      broad_phase.test_pairs({chunk_, chunks});
    }
    broad_phase.add_remaining_pairs();
    broad_phase.expand_patch_pairs();
  }

  void launch() {
    is_all_enqueued_ = false;
    w_.counters.reserve(backend_, 1, 0);
    // Samples of several ranks' tests are of entries in the order of cells. Bins take memory.
    w_.lays_into_bins = !Backend::kKnowsCounts && query_->lays_into_bins && settings_.partition.is_whole() &&
                        !account_->is_limited() && w_.lists.entries.capacity() <= kMostEntriesInBins;
    if (may_keep_ && !has_reused_) {
      keeping_.emplace(backend_, w_, scene_, host_bodies(), settings_, revision_, query_->usefulness);
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

  /// Returns the bodies on the host. Valid while the detection is started; on the CPU until it is finished.
  SceneBodies host_bodies() const {
    if constexpr (Backend::kKnowsCounts) {
      const std::size_t count = scene_.body_count;
      const std::size_t partners = count == 0 ? 0 : scene_.partner_begin[count];
      return {{scene_.bodies, count}, {scene_.partner_begin, count + 1}, {scene_.partners, partners}};
    } else {
      return given_bodies_;
    }
  }

  Signature signature(LaunchPart part) {
    return {part,
            may_keep_ ? keeping_->work() : KeepingWork{},
            w_.kept.pairs.capacity(),
            settings_,
            scene_,
            counts_,
            chunks_,
            query_->orders_in_runs,
            w_.lays_into_bins,
            body_ids_,
            verdict_.is_as_predicted,
            w_.lists.with_all([](auto&... lists) { return std::array{lists.capacity()...}; })};
  }

  /// Counts vertex-triangle contacts, which come first.
  static std::uint64_t vertex_triangle_count(Span<const Contact> contacts) {
    const auto* end = std::partition_point(contacts.begin(), contacts.end(), [](const Contact& contact) {
      return contact.kind == ContactKind::vertex_triangle;
    });
    return static_cast<std::uint64_t>(end - contacts.begin());
  }

  void report(const Counters& counters, Span<const Contact> contacts, Statistics& statistics) const {
    statistics.active_triangles = counters.grid.active_triangles;
    statistics.mean_radius = static_cast<double>(counters.grid.mean_radius);
    statistics.cell_size = static_cast<double>(counters.grid.cell_size);
    statistics.split_triangles = counters.splits;
    statistics.children = counters.children;
    statistics.big_triangles = counters.bigs;
    statistics.entries = counters.entries;
    statistics.cells = counters.cells;
    statistics.tests = has_reused_ ? counters.kept : counters.tests + counters.bigs * counters.grid.active_elements;
    statistics.reused_pairs = has_reused_;
    statistics.triangle_pairs = query_->total.pairs;
    statistics.flagged_pairs = counters.flagged;
    statistics.vt_candidates = query_->total.vt_candidates;
    statistics.ee_candidates = query_->total.ee_candidates;
    statistics.vt_contacts = settings_.contacts_stay ? counters.vt_contacts : vertex_triangle_count(contacts);
    statistics.ee_contacts = contacts.size() - statistics.vt_contacts;
    statistics.unsettled_contacts = counters.unsettled;
    statistics.earliest_toi = static_cast<double>(counters.earliest_toi);
    report_memory(statistics);
    statistics.ms = backend_.times();
  }

  std::shared_ptr<MemoryAccount> account_;
  SceneMirror<Backend> mirror_;
  Workspace<Backend, Scheme> w_;
  Bvhs<Backend> bvhs_;
  SceneView scene_;
  SceneCounts counts_{};
  std::uint32_t patch_count_ = 0;
  PredictionVerdict verdict_;         ///< see SceneChanges
  std::uint64_t scene_revision_ = 0;  ///< see SceneArrays
  std::uint64_t revision_ = 1;        ///< changes with the triangles and the memory that there is for them
  // About the detection that was started last:
  QueryOn<Backend>* query_ = nullptr;
  DetectionSettings settings_{};
  std::uint64_t chunks_ = 1;  ///< parts that the pair tests are made in
  std::uint32_t chunk_ = 0;   ///< the current one, or the one in which memory ran out
  std::uint32_t first_chunk_ =
      0;                       ///< the one that runs first: what did not fit before shows at once whether it does now
  Counters reached_{};         ///< of its last attempt that was finished; 0 at its start
  bool has_released_ = false;  ///< its lists have only what it needs itself
  bool is_launched_ = false;
  bool is_all_enqueued_ = false;                         ///< by the last attempt; on the CPU, once it has run
  void* ready_ = nullptr;                                ///< see StayingContacts
  std::uint32_t body_ids_ = 0;                           ///< where contacts stay; see DeviceContacts
  bool may_keep_ = false;                                ///< it may keep pairs for later detections, or reuse kept ones
  bool has_reused_ = false;                              ///< it reuses pairs of an earlier detection
  SceneBodies given_bodies_;                             ///< until it is started
  std::optional<PairKeeping<Backend, Scheme>> keeping_;  ///< set if may_keep_
  MemoryNeed::For needs_ = MemoryNeed::For::scene;       ///< what is being done
  std::uint64_t found_ = 0;                              ///< contacts, when memory ran out
  TestSamples test_samples_;
  Backend backend_;  ///< last, so that it is destroyed first: it waits for work that uses the others
};

}  // namespace softcd

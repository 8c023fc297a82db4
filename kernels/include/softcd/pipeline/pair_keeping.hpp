#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "softcd/pipeline/broad_phase.hpp"
#include "softcd/pipeline/workspace.hpp"

namespace softcd {

/// The part of a detection that reuses kept pairs, or keeps something for later ones. Decisions and enqueued work are
/// separate, because the host of some backends decides before anything runs.
template <class Backend, class Scheme>
class PairKeeping {
  using Stages = BroadPhaseStages<Backend, Scheme>;

 public:
  /// `bodies` are the scene's, on the host, for decisions. `revision` is the detector's. `usefulness` is that of what
  /// the query's detections keep.
  PairKeeping(Backend& backend, Workspace<Backend, Scheme>& workspace, const SceneView& scene,
              const SceneBodies& bodies, const DetectionSettings& settings, std::uint64_t revision,
              std::shared_ptr<Usefulness> usefulness)
      : backend_(backend),
        w_(workspace),
        scene_(scene),
        bodies_(bodies),
        settings_(settings),
        revision_(revision),
        usefulness_(std::move(usefulness)) {
    for_each_kept([this](std::uint32_t /*i*/) { kept().age += is_own() ? 1 : 0; });
    choose_compared();
    ++kept().misses;
    work_.compares = covers();
    work_.measures_headroom = work_.compares && is_own();
  }

  /// Returns the work to be enqueued, as far as it is decided.
  const KeepingWork& work() const { return work_; }
  /// Whether it pays to wait for the comparison. Waiting costs nothing if counts are known at once.
  bool waits_for_comparison() const { return work_.compares && (Backend::kKnowsCounts || kept().has_pairs); }

  /// Enqueues the comparison with the kept volumes. The triangles must be bounded. The results are among the counts.
  void enqueue_comparison(Stages& stages) const {
    if (!work_.compares) return;
    stages.find_escaped();
    if constexpr (Backend::kKnowsCounts) {
      if (w_.counters.data()->escaped == 0) return;
    }
    if (work_.measures_headroom) stages.measure_headroom();
  }

  /// Whether to reuse the kept pairs, by the counts of the comparison: at most a few triangles have escaped.
  bool is_served(const Counters& counters) {
    learn(lesson(), counters);
    if (!have_few_escaped(counters)) {
      if (!is_own()) choose_replaced();
      return false;
    }
    work_.looks_up_escaped = counters.escaped > 0;
    kept().misses = 0;
    kept().was_of_use = true;
    return kept().has_pairs;
  }

  void enqueue_reuse(Stages& stages) const {
    backend_.run_once("restore_kept_counts", RestoreKeptCounts{kept().counts.data(), w_.counters.data()});
    stages.test_kept_pairs();
    if (work_.looks_up_escaped) stages.look_up_escaped();
  }

  /// Decides what a detection that reuses no pairs keeps:
  /// - nothing if it is the detector's first;
  /// - volumes, from which later detections learn whether pairs would have been of use;
  /// - pairs, too, if these are likely to be of use.
  void begin() {
    if (work_.compares && !waits_for_comparison()) lesson_ = lesson();
    if (!std::exchange(w_.has_detected, true) || w_.has_split || is_others()) return;
    const bool leaves = usefulness_->is_likely() || usefulness_->wants_to_learn();
    if (!leaves && !is_own()) return;
    if (kept().has_pairs && !kept().was_of_use) kept().usefulness->doubt();
    kept().has_pairs = false;
    kept().revision = 0;
    if (!leaves || !lists_all_neighbours()) return;
    work_.keeps_volumes = true;
    work_.keeps_pairs = kept().has_pairs = usefulness_->is_likely();
    work_.slack = kept().slack = kept().has_pairs ? usefulness_->slack() : 0.0F;
    kept().bodies.assign(bodies_.bodies.begin(), bodies_.bodies.end());
    kept().partner_begin.assign(bodies_.partner_begin.begin(), bodies_.partner_begin.end());
    kept().partners.assign(bodies_.partners.begin(), bodies_.partners.end());
    kept().volumes.reserve(backend_, scene_.element_count(), 0);
    if (is_grown()) upload_grown_bodies();
    if (!kept().has_pairs) return;
    kept().counts.reserve(backend_, 1, 0);
    if (!Backend::kKnowsCounts) kept().pairs.reserve(backend_, w_.lists.pairs.capacity(), 0);
  }

  /// Keeps the volumes. The triangles must be bounded and compared.
  void enqueue_volumes(Stages& stages) const {
    if (!work_.keeps_volumes) return;
    if (is_grown()) {
      SceneView scene = scene_;
      scene.bodies = kept().grown_bodies.data();
      stages.bound_triangles(scene);
    }
    stages.keep_volumes(kept().slack);
  }

  /// Whether the detection keeps pairs of grown volumes.
  bool grows_volumes() const { return work_.keeps_pairs && is_grown(); }

  /// Runs f. Its stages use grown volumes if the detection keeps pairs of these.
  template <class F>
  void with_kept_volumes(const F& f) {
    const bool swaps = grows_volumes();
    if (swaps) std::swap(w_.volumes, kept().volumes);
    f();
    if (swaps) std::swap(w_.volumes, kept().volumes);
  }

  /// Keeps all pairs whose volumes overlap, and finds this detection's pairs. Called within with_kept_volumes().
  void enqueue_pairs(Stages& stages) const {
    stages.keep_pairs(grows_volumes() ? kept().volumes.data() : w_.volumes.data());
    backend_.run_once("store_kept_counts", StoreKeptCounts{w_.counters.data(), kept().counts.data()});
  }

  /// Discards the kept pairs, which are not complete.
  void drop() { kept().has_pairs = false; }

  /// Called when all has run. Later detections get nothing if triangles were split: their pairs were found by the cells
  /// of their children, not by their volumes.
  void conclude(const Counters& counters) {
    if (lesson_) learn(*lesson_, counters);
    if (!work_.keeps_volumes || counters.splits > 0) return;
    kept().settings = settings_;
    kept().usefulness = usefulness_;
    kept().was_of_use = false;
    kept().age = 0;
    kept().number = ++w_.kept_count;
    kept().mean_radius = counters.grid.mean_radius;
    kept().revision = revision_;
  }

 private:
  /// Detections in a row that the kept pairs do not serve, before those of another query may replace them.
  static constexpr int kMostMisses = 4;

  /// Properties of the kept detection that are needed to learn from a comparison with it.
  struct Lesson {
    std::shared_ptr<Usefulness> usefulness;
    float slack, mean_radius;
    int age;
  };

  KeptPairs<Backend>& kept() const { return w_.kept(); }

  bool covers() const { return is_kept() && covers_settings() && covers_bodies(); }

  /// Chooses the kept results to compare with: of those that cover the pairs of bodies the query's own pairs, otherwise
  /// the newest. In a step of moving bodies these are of the query before this one.
  void choose_compared() {
    std::optional<std::uint32_t> best;
    const auto rank = [this] { return std::pair(is_own() && kept().has_pairs, kept().number); };
    std::pair<bool, std::uint64_t> best_rank;
    for_each_kept([&](std::uint32_t i) {
      if (!covers() || (best && rank() < best_rank)) return;
      best = i;
      best_rank = rank();
    });
    best ? void(w_.kept_number = *best) : choose_replaced();
  }

  /// Chooses the kept results that this detection may replace: the query's own, or unused ones if there are any.
  void choose_replaced() {
    std::optional<std::uint32_t> own, unused;
    for_each_kept([&](std::uint32_t i) {
      if (is_own()) own = i;
      if (!is_kept()) unused = i;
    });
    w_.kept_number = own.value_or(unused.value_or(w_.kept_number));
  }

  /// Calls f(i) for all kept results, with each as kept().
  template <class F>
  void for_each_kept(const F& f) {
    const std::uint32_t before = w_.kept_number;
    for (std::uint32_t i = 0; i < kMostKept; ++i) f(w_.kept_number = i);
    w_.kept_number = before;
  }

  bool is_kept() const { return kept().revision == revision_; }
  bool is_own() const { return kept().usefulness == usefulness_; }
  bool is_grown() const { return kept().slack > 0.0F; }

  /// Whether another query has kept pairs that are still of use.
  bool is_others() const { return is_kept() && kept().has_pairs && !is_own() && kept().misses < kMostMisses; }

  Lesson lesson() const { return {kept().usefulness, kept().slack, kept().mean_radius, kept().age}; }

  static bool have_few_escaped(const Counters& counters) {
    constexpr std::uint64_t kShare = 8;
    return counters.escaped <= kMostEscaped && kShare * counters.escaped <= counters.active;
  }

  void learn(const Lesson& lesson, const Counters& counters) {
    if (have_few_escaped(counters)) {
      lesson.usefulness->confirm();
    } else if (work_.measures_headroom) {
      const float move = lesson.slack - counters.headroom;
      lesson.usefulness->learn(move / static_cast<float>(lesson.age), lesson.mean_radius);
    }
  }

  /// Whether the grid's settings are the same. Other settings give the same contacts, but the caller wants to see their
  /// work.
  bool covers_settings() const {
    return kept().settings.broad_phase == settings_.broad_phase &&
           kept().settings.subdivision == settings_.subdivision &&
           kept().settings.cell_size_factor == settings_.cell_size_factor;
  }

  /// Whether the kept pairs cover all pairs of bodies and all kinds of features.
  bool covers_bodies() const {
    if (!lists_all_neighbours()) return false;
    for (std::size_t b = 0; b < bodies_.bodies.size(); ++b) {
      const SceneBody& now = bodies_.bodies[b];
      const SceneBody& then = kept().bodies[b];
      if ((now.vertex_triangle && !then.vertex_triangle) || (now.edge_edge && !then.edge_edge)) return false;
      const auto partners_now = bodies_.row(b);
      const auto partners_then = SceneBodies{kept().bodies, kept().partner_begin, kept().partners}.row(b);
      if (!std::includes(partners_then.begin(), partners_then.end(), partners_now.begin(), partners_now.end())) {
        return false;
      }
    }
    return true;
  }

  /// Whether all bodies that collide with themselves list their neighbours. Otherwise positions decide which features
  /// of triangles with a common vertex may touch.
  bool lists_all_neighbours() const {
    for (std::uint32_t b = 0; b < bodies_.bodies.size(); ++b) {
      const auto partners = bodies_.row(b);
      if (!bodies_.bodies[b].lists_neighbours && std::binary_search(partners.begin(), partners.end(), b)) return false;
    }
    return true;
  }

  /// Uploads bodies with grown boxes of partners. So triangles take part that may come within reach of a partner before
  /// any triangle leaves its grown volume.
  void upload_grown_bodies() {
    std::vector<SceneBody> grown = kept().bodies;
    for (SceneBody& body : grown) body.partner_box = inflated(body.partner_box, kept().slack);
    kept().grown_bodies.reserve(backend_, grown.size(), 0);
    backend_.upload(kept().grown_bodies, Span<const SceneBody>(grown));
  }

  Backend& backend_;
  Workspace<Backend, Scheme>& w_;
  const SceneView& scene_;
  SceneBodies bodies_;
  const DetectionSettings& settings_;
  std::uint64_t revision_;
  std::shared_ptr<Usefulness> usefulness_;
  KeepingWork work_;
  std::optional<Lesson> lesson_;
};

}  // namespace softcd

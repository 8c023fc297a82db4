#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

#include "softcd/pipeline/broad_phase.hpp"
#include "softcd/pipeline/workspace.hpp"

namespace softcd {

/// What one look does with the kept one: finds its pairs among those, or else leaves something itself. For backends
/// whose counts, and memory, the host can read meanwhile.
template <class Backend, class Scheme>
class LookKeeping {
 public:
  /// `revision` is the detector's, `usefulness` of what the query's looks leave.
  LookKeeping(Backend& backend, Workspace<Backend, Scheme>& workspace, BroadPhaseStages<Backend, Scheme>& stages,
              const SceneView& scene, const DetectionSettings& settings, std::uint64_t revision,
              const std::shared_ptr<Usefulness>& usefulness)
      : backend_(backend),
        volumes_(workspace.volumes),
        counters_(*workspace.counters.data()),
        kept_(workspace.kept),
        stages_(stages),
        scene_(scene),
        settings_(settings),
        revision_(revision),
        usefulness_(usefulness) {}

  /// Of triangles that are bounded: whether all pairs were found among those kept.
  bool reuse() {
    ++kept_.misses;
    if (is_own()) ++kept_.age;
    if (!is_kept() || !covers_settings() || !covers_bodies()) return false;
    stages_.find_escaped();
    if (counters_.escaped > 0) {
      if (is_own()) learn();
      return false;
    }
    kept_.misses = 0;
    kept_.was_of_use = true;
    kept_.usefulness->confirm();
    if (!kept_.has_pairs) return false;
    counters_.kept = kept_.pair_count;
    counters_.grid = kept_.grid;
    counters_.grid.active_triangles = static_cast<std::uint32_t>(counters_.active);
    stages_.test_kept_pairs();
    return true;
  }

  /// Of triangles that are bounded: leaves their volumes, which tell whether pairs would have been of use; by a
  /// detector's first look nothing is left. Where pairs shall be kept the stages go on with the grown volumes.
  void begin() {
    if (!std::exchange(kept_.has_looked, true) || kept_.has_split || is_others()) return;
    if (kept_.has_pairs && !kept_.was_of_use) kept_.usefulness->doubt();
    kept_.revision = 0;
    if (!lists_all_neighbours()) return;
    begins_ = true;
    kept_.has_pairs = usefulness_->is_likely();
    kept_.slack = kept_.has_pairs ? usefulness_->slack() : 0.0F;
    keep_bodies();
    if (is_grown()) bound_those_near();
    stages_.keep_volumes(kept_.slack);
    if (is_grown()) std::swap(volumes_, kept_.volumes);
  }

  bool keeps_pairs() const { return begins_ && kept_.has_pairs; }

  /// Of triangles that are prepared: whether all pairs were found, because those of overlapping volumes are kept.
  bool keep() {
    kept_.has_split = counters_.splits > 0;
    const bool keeps = begins_ && !kept_.has_split;
    if (keeps && keeps_pairs()) stages_.keep_pairs();
    if (begins_ && is_grown()) std::swap(volumes_, kept_.volumes);
    if (!keeps) return false;
    kept_.settings = settings_;
    kept_.usefulness = usefulness_;
    kept_.was_of_use = false;
    kept_.age = 0;
    kept_.pair_count = counters_.kept;
    kept_.grid = counters_.grid;
    kept_.revision = revision_;
    if (kept_.has_pairs) stages_.test_kept_pairs();
    return kept_.has_pairs;
  }

 private:
  /// Looks in a row that the kept one is of no use to before another query's may take its place.
  static constexpr int kMostMisses = 4;

  bool is_kept() const { return kept_.revision == revision_; }
  bool is_own() const { return kept_.usefulness == usefulness_; }
  bool is_grown() const { return kept_.slack > 0.0F; }

  /// Another query has left pairs that still are of use.
  bool is_others() const { return is_kept() && kept_.has_pairs && !is_own() && kept_.misses < kMostMisses; }

  void learn() {
    stages_.measure_headroom();
    const float move = kept_.slack - counters_.headroom;
    usefulness_->learn(move / static_cast<float>(kept_.age), kept_.grid.mean_radius);
  }

  /// Others have no other contacts, but want to be seen at work.
  bool covers_settings() const {
    return kept_.settings.broad_phase == settings_.broad_phase && kept_.settings.subdivision == settings_.subdivision &&
           kept_.settings.lambda == settings_.lambda;
  }

  /// Whether all pairs of bodies, and kinds of features, were looked for.
  bool covers_bodies() const {
    if (!lists_all_neighbours()) return false;
    for (std::uint32_t b = 0; b < scene_.body_count; ++b) {
      const SceneBody& now = scene_.bodies[b];
      const SceneBody& then = kept_.bodies.data()[b];
      if ((now.vertex_triangle && !then.vertex_triangle) || (now.edge_edge && !then.edge_edge)) return false;
      const auto row = [b](const std::uint64_t* begin, const std::uint32_t* partners) {
        return Span<const std::uint32_t>(partners + begin[b], begin[b + 1] - begin[b]);
      };
      const auto partners_now = row(scene_.partner_begin, scene_.partners);
      const auto partners_then = row(kept_.partner_begin.data(), kept_.partners.data());
      if (!std::includes(partners_then.begin(), partners_then.end(), partners_now.begin(), partners_now.end())) {
        return false;
      }
    }
    return true;
  }

  /// What triangles that share a vertex may touch with is decided by where they are, unless it is listed.
  bool lists_all_neighbours() const {
    for (std::uint32_t b = 0; b < scene_.body_count; ++b) {
      if (!scene_.bodies[b].lists_neighbours && scene_.bodies_may_touch(b, b)) return false;
    }
    return true;
  }

  void keep_bodies() {
    const auto keep = [this](auto& buffer, const auto* values, std::uint64_t count) {
      buffer.reserve(backend_, count, 0);
      backend_.upload(buffer, {values, count});
    };
    keep(kept_.bodies, scene_.bodies, scene_.body_count);
    keep(kept_.partner_begin, scene_.partner_begin, scene_.body_count + 1);
    keep(kept_.partners, scene_.partners, scene_.partner_begin[scene_.body_count]);
  }

  /// Those too that may come within reach of a partner before any leaves its grown volume.
  void bound_those_near() {
    for (std::uint32_t b = 0; b < scene_.body_count; ++b) {
      Box& box = kept_.bodies.data()[b].partner_box;
      box = inflated(box, kept_.slack);
    }
    SceneView scene = scene_;
    scene.bodies = kept_.bodies.data();
    stages_.bound_triangles(scene);
  }

  Backend& backend_;
  typename Backend::template Buffer<Kdop18>& volumes_;
  Counters& counters_;
  KeptLook<Backend>& kept_;
  BroadPhaseStages<Backend, Scheme>& stages_;
  const SceneView& scene_;
  const DetectionSettings& settings_;
  std::uint64_t revision_;
  const std::shared_ptr<Usefulness>& usefulness_;
  bool begins_ = false;
};

}  // namespace softcd

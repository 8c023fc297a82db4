#pragma once

#include <algorithm>
#include <cstdint>

#include "softcd/pipeline/query_on.hpp"
#include "softcd/pipeline/scene_mirror.hpp"
#include "softcd/pipeline/spatial_queries_on.hpp"

namespace softcd {

/// A detector's scene on a backend: its arrays, what stages see of them, and the hierarchies for probes.
template <class Backend>
class SceneOn {
 public:
  /// Makes the arrays follow the host's changes. May be called again after it has thrown.
  void follow(Backend& backend, const SceneArrays& scene, const SceneChanges& changes) {
    verdict_ = changes.verdict;
    follow_meshes(backend, scene, changes);
    follow_positions(backend, scene, changes);
    follow_filters(backend, scene.filters, changes.filters);
    counts_ = {scene.triangles.size(), scene.vertex_triangle_neighbours.size(), scene.edge_edge_neighbours.size(),
               scene.stars.size()};
    view_.triangle_count = static_cast<std::uint32_t>(scene.triangles.size());
    view_.edge_count = static_cast<std::uint32_t>(scene.edges.size());
    view_.vertex_count = static_cast<std::uint32_t>(scene.vertex_body.size());
    patch_count_ = static_cast<std::uint32_t>(scene.patch_triangles.size() / kPatchSize);
  }

  const SceneMirror<Backend>& mirror() const { return mirror_; }
  const SceneCounts& counts() const { return counts_; }
  const PredictionVerdict& verdict() const { return verdict_; }
  /// Returns the scene as the stages of the last begun detection see it.
  const SceneView& view() const { return view_; }

  /// Makes view() that of a detection of these bodies, which `query` has on the backend.
  void begin_detection(const DetectionSettings& settings, const QueryOn<Backend>& query, const SceneBodies& bodies,
                       bool has_patches) {
    view_meshes(has_patches);
    view_positions(settings);
    view_bodies(query, bodies);
    const bool continuous = settings.detection == Detection::ccd;
    view_.is_swept = continuous && settings.both_ends;
    view_.motion_margin = continuous ? 0.0F : settings.motion_margin;
    view_.is_conservative = settings.accuracy == Accuracy::conservative;
    view_.contact_rule = continuous ? ContactRule::distance : settings.contact_rule;
  }

  /// Returns the scene as the stages of a probe see it. Builds the hierarchy of the probed end of the step, unless it
  /// is up to date.
  ProbedSceneView probed(Backend& backend, const ProbedScene& scene, const ProbeOn<Backend>& probe) {
    const Vec3f* const x = scene.at_t0 ? mirror_.x_t0.data() : mirror_.x_t1.data();
    const Vec3d* const full = scene.at_t0 ? mirror_.full_t0.data() : mirror_.full_t1.data();
    Bvh<Backend>& bvh = bvhs_[scene.at_t0 ? 0 : 1];
    bvh.build(backend,
              {x, mirror_.triangles.data(), mirror_.ownership.data(), mirror_.triangle_body.data(),
               view_.triangle_count, scene.bounds},
              scene.revision);
    const Vec3d lo = vec3_cast<double>(scene.bounds.lo);
    const Vec3d hi = vec3_cast<double>(scene.bounds.hi);
    return {bvh.view(),
            probe.bodies.data(),
            mirror_.triangles.data(),
            mirror_.ownership.data(),
            x,
            scene.covers_rounding ? full : nullptr,
            mirror_.triangle_body.data(),
            scene.origin,
            0.5 * (lo + hi),
            0.5 * max_norm(hi - lo)};
  }

  /// Releases the arrays. All of the scene then counts as changed.
  void release() { mirror_ = {}; }
  void release_hierarchies() { bvhs_ = {}; }

 private:
  void follow_meshes(Backend& backend, const SceneArrays& scene, const SceneChanges& changes) {
    mirror_.triangles.follow(backend, scene.triangles, changes.triangles);
    mirror_.triangle_edges.follow(backend, scene.triangle_edges, changes.triangles);
    mirror_.ownership.follow(backend, scene.ownership, changes.triangles);
    if constexpr (Backend::kHasPatches) {
      mirror_.patch_triangles.follow(backend, scene.patch_triangles, changes.patches);
    }
    mirror_.ownership.follow(backend, scene.ownership, changes.ownership);
    mirror_.triangle_body.follow(backend, scene.triangle_body, changes.triangles);
    mirror_.edges.follow(backend, scene.edges, changes.edges);
    mirror_.vertex_body.follow(backend, scene.vertex_body, changes.vertices);
    mirror_.vertex_triangle_neighbours.follow(backend, scene.vertex_triangle_neighbours,
                                              changes.vertex_triangle_neighbours);
    mirror_.edge_edge_neighbours.follow(backend, scene.edge_edge_neighbours, changes.edge_edge_neighbours);
    mirror_.stars.follow(backend, scene.stars, changes.stars);
  }

  void follow_positions(Backend& backend, const SceneArrays& scene, const SceneChanges& changes) {
    mirror_.x_t0.follow(backend, scene.x_t0, changes.x_t0);
    mirror_.x_t1.follow(backend, scene.x_t1, changes.x_t1);
    mirror_.full_t0.follow(backend, scene.full_t0, changes.full_t0);
    mirror_.full_t1.follow(backend, scene.full_t1, changes.full_t1);
    if constexpr (!Backend::kKnowsCounts) {
      if (verdict_.known != nullptr) backend.wait_for(verdict_.known);
      mirror_.x_t0.place(backend, changes.device_x_t0, changes.origin);
      mirror_.x_t1.place(backend, changes.device_x_t1, changes.origin);
      mirror_.full_t0.place(backend, changes.device_full_t0, changes.origin);
      mirror_.full_t1.place(backend, changes.device_full_t1, changes.origin);
    }
  }

  void follow_filters(Backend& backend, const FilterArrays& filters, bool have_changed) {
    view_.filters = {followed(backend, mirror_.vertex_filters, filters.vertices, have_changed),
                     followed(backend, mirror_.ring_begin, filters.ring_begin, have_changed),
                     followed(backend, mirror_.ring_vertices, filters.ring_vertices, have_changed),
                     followed(backend, mirror_.x_rest, filters.x_rest, have_changed)};
  }

  /// Returns the values in the backend's memory; null if there are none.
  template <class T>
  static const T* followed(Backend& backend, typename Backend::template Mirror<T>& mirror, Span<const T> values,
                           bool have_changed) {
    const Range all = {0, have_changed ? values.size() : 0};
    mirror.follow(backend, values, Span<const Range>(&all, 1));
    return values.empty() ? nullptr : mirror.data();
  }

  void view_meshes(bool has_patches) {
    view_.triangles = mirror_.triangles.data();
    view_.triangle_edges = mirror_.triangle_edges.data();
    view_.edges = mirror_.edges.data();
    view_.ownership = mirror_.ownership.data();
    view_.triangle_body = mirror_.triangle_body.data();
    view_.patch_triangles = mirror_.patch_triangles.data();
    view_.patch_count = has_patches ? patch_count_ : 0;
    view_.vertex_body = mirror_.vertex_body.data();
  }

  void view_positions(const DetectionSettings& settings) {
    view_.x_t1 = settings.at_t0 ? mirror_.x_t0.data() : mirror_.x_t1.data();
    view_.x_t0 = settings.both_ends ? mirror_.x_t0.data() : view_.x_t1;
    view_.full_t0 = view_.full_t1 = nullptr;
    if (!settings.covers_rounding) return;
    view_.full_t1 = settings.at_t0 ? mirror_.full_t0.data() : mirror_.full_t1.data();
    view_.full_t0 = settings.both_ends ? mirror_.full_t0.data() : view_.full_t1;
  }

  void view_bodies(const QueryOn<Backend>& query, const SceneBodies& bodies) {
    view_.bodies = query.bodies.data();
    view_.partner_begin = query.partner_begin.data();
    view_.partners = query.partners.data();
    view_.body_count = static_cast<std::uint32_t>(bodies.bodies.size());
    view_.summarize_pairs(bodies.partner_begin, bodies.partners);
    view_.has_batches = std::any_of(bodies.bodies.begin(), bodies.bodies.end(),
                                    [](const SceneBody& body) { return body.cell_offset != 0; });
    view_.filters.are_set = view_.filters.vertices != nullptr ||
                            std::any_of(bodies.bodies.begin(), bodies.bodies.end(), [](const SceneBody& body) {
                              return body.excludes_rings || body.rest_distance > 0.0F;
                            });
  }

  SceneMirror<Backend> mirror_;
  Bvhs<Backend> bvhs_;
  SceneView view_;
  SceneCounts counts_{};
  std::uint32_t patch_count_ = 0;
  PredictionVerdict verdict_;  ///< see SceneChanges
};

}  // namespace softcd

#include "scene.hpp"

#include <algorithm>
#include <cstring>
#include <ostream>
#include <set>
#include <stdexcept>
#include <utility>

namespace softcd::test {

static_assert(sizeof(Contact) == 18 * 4, "no padding, so bytes can be compared");

BodySettings everything(float margin) {
  BodySettings settings;
  settings.margin = margin;
  settings.self_collision = true;
  settings.features = {true, true};
  return settings;
}

SceneBody still(const Mesh& mesh, BodySettings settings) {
  return {mesh.triangles, mesh.positions, mesh.positions, settings};
}

SceneBody moving(const Mesh& mesh, Positions3 x_t1, BodySettings settings) {
  return {mesh.triangles, mesh.positions, std::move(x_t1), settings};
}

std::ostream& operator<<(std::ostream& out, const FeaturePair& pair) {
  const bool is_vt = pair.kind == ContactKind::vertex_triangle;
  return out << (is_vt ? "vertex " : "edge ") << pair.body_a << ':' << pair.feature_a
             << (is_vt ? " triangle " : " edge ") << pair.body_b << ':' << pair.feature_b;
}

std::vector<Edge> edges_of(const std::vector<Triangle>& triangles) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;
  for (const Triangle& t : triangles) {
    for (int i = 0; i < 3; ++i) {
      const std::pair<std::uint32_t, std::uint32_t> pair = std::minmax(t.v[i], t.v[(i + 1) % 3]);
      if (pair.first != pair.second) ends.push_back(pair);
    }
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  std::vector<Edge> edges;
  edges.reserve(ends.size());
  for (const auto& [low, high] : ends) edges.push_back({{low, high}});
  return edges;
}

std::vector<Edge> edges_of(const SceneBody& body) {
  std::vector<Edge> edges = edges_of(body.triangles);
  std::set<std::pair<std::uint32_t, std::uint32_t>> known;
  for (const Edge& edge : edges) known.emplace(edge.v[0], edge.v[1]);
  for (const Segment& segment : body.segments) {
    const auto [low, high] = std::minmax(segment.v[0], segment.v[1]);
    if (low != high && known.emplace(low, high).second) edges.push_back({{low, high}});
  }
  return edges;
}

LoadedScene load(Scene scene, const PipelineOptions& options, LogCallback log) {
  LoadedScene loaded{std::move(scene), CollisionPipeline(options, std::move(log)), {}};
  for (const SceneBody& body : loaded.scene) {
    const auto vertex_count = static_cast<std::uint32_t>(body.x_t1.size());
    const BodyId id = loaded.pipeline.scene.add_body({body.triangles, vertex_count, body.settings, -1, body.segments});
    loaded.pipeline.scene.set_positions(id, body.x_t0, body.x_t1);
    loaded.ids.push_back(id);
  }
  return loaded;
}

PipelineOptions test_options(Detection detection, BroadPhase broad_phase) {
  PipelineOptions options;
  options.backend = backend_under_test();
  options.detection = detection;
  options.accuracy = Accuracy::precise;
  options.broad_phase = broad_phase;
  return options;
}

Outcome outcome_of(const Scene& scene, const PipelineOptions& options, const PairFilter& pair_filter) {
  LoadedScene loaded = load(scene, options);
  loaded.pipeline.query.set_pair_filter(pair_filter);
  const Span<const Contact> contacts = loaded.pipeline.detect();
  const Statistics& statistics = loaded.pipeline.query.statistics();
  if (options.backend != Backend::automatic && statistics.backend != options.backend) {
    throw std::logic_error("another backend than the one under test has detected");
  }
  return {{contacts.begin(), contacts.end()}, statistics, loaded.pipeline.query.explain()};
}

std::vector<Contact> detect_once(const Scene& scene, const PipelineOptions& options, const PairFilter& pair_filter) {
  return outcome_of(scene, options, pair_filter).contacts;
}

FeaturePair features_of(const Contact& c) {
  return {c.kind, c.body_a.value, c.feature_a, c.body_b.value, c.feature_b};
}

std::vector<FeaturePair> features_of(Span<const Contact> contacts) {
  std::vector<FeaturePair> pairs;
  for (const Contact& contact : contacts) pairs.push_back(features_of(contact));
  return pairs;
}

bool identical(Span<const Contact> a, Span<const Contact> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Contact)) == 0);
}

}  // namespace softcd::test

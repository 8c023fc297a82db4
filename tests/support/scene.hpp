#pragma once

#include <compare>
#include <cstdint>
#include <iosfwd>
#include <vector>

#include "backend_under_test.hpp"
#include "mesh_generators.hpp"
#include "softcd/softcd.hpp"

namespace softcd::test {

struct SceneBody {
  std::vector<Triangle> triangles;
  Positions3 x_t0;
  Positions3 x_t1;
  BodySettings settings;
  std::vector<Segment> segments{};
};

using Scene = std::vector<SceneBody>;

/// Both kinds of features, self collision on: what most tests want.
BodySettings everything(float margin = 0.0F);

SceneBody still(const Mesh& mesh, BodySettings settings);
SceneBody moving(const Mesh& mesh, Positions3 x_t1, BodySettings settings);

/// Two features, bodies by their place in the scene, ordered as the detector's contacts are.
struct FeaturePair {
  ContactKind kind = ContactKind::vertex_triangle;
  std::uint32_t body_a = 0;
  std::uint32_t feature_a = 0;
  std::uint32_t body_b = 0;
  std::uint32_t feature_b = 0;

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 takes what this compares with for a pointer.
  friend auto operator<=>(const FeaturePair&, const FeaturePair&) = default;
};
std::ostream& operator<<(std::ostream& out, const FeaturePair& pair);

/// A body's edges in the order that Contact documents: sorted by lower, then higher vertex.
std::vector<Edge> edges_of(const std::vector<Triangle>& triangles);
/// Those of the triangles, then those of segments that are not among them yet, in their order.
std::vector<Edge> edges_of(const SceneBody& body);

/// A pipeline that holds a scene's bodies, ids in the scene's order, and the scene, since positions are read by
/// detect() only.
struct LoadedScene {
  Scene scene;
  CollisionPipeline pipeline;
  std::vector<BodyId> ids;
};
LoadedScene load(Scene scene, const PipelineOptions& options, LogCallback log = {});

/// The options of one detection on the backend under test: `precise`, whatever positions are given as.
PipelineOptions test_options(Detection detection, BroadPhase broad_phase = BroadPhase::exact);

/// What a fresh pipeline's first detection leaves. Throws where another backend than the one asked for has answered.
struct Outcome {
  std::vector<Contact> contacts;
  Statistics statistics;
  std::vector<StageReport> report;
};
Outcome outcome_of(const Scene& scene, const PipelineOptions& options, const PairFilter& pair_filter = {});

/// Its contacts.
std::vector<Contact> detect_once(const Scene& scene, const PipelineOptions& options,
                                 const PairFilter& pair_filter = {});

FeaturePair features_of(const Contact& contact);
std::vector<FeaturePair> features_of(Span<const Contact> contacts);

/// The same bytes, padding included: contacts have none.
bool identical(Span<const Contact> a, Span<const Contact> b);

}  // namespace softcd::test

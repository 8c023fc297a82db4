#pragma once

#include <compare>
#include <cstdint>
#include <iosfwd>
#include <vector>

#include "backend_under_test.hpp"
#include "mesh_generators.hpp"
#include "softcd/mesh/features.hpp"
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

/// Returns settings with both kinds of features and self-collision, for most tests.
BodySettings everything(float margin = 0.0F);

SceneBody still(const Mesh& mesh, BodySettings settings);
SceneBody moving(const Mesh& mesh, Positions3 x_t1, BodySettings settings);

/// Two features, with bodies numbered by their places in the scene, in the order of the detector's contacts.
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

/// Returns a body's edges in the order that Contact documents: sorted by lower, then higher vertex.
std::vector<Edge> edges_of(const std::vector<Triangle>& triangles);
/// Returns the edges of the triangles, then those of segments that are not among them yet, in their order.
std::vector<Edge> edges_of(const SceneBody& body);

/// A pipeline with a scene's bodies, whose ids are in the scene's order. It also keeps the scene, because only detect()
/// reads positions.
struct LoadedScene {
  Scene scene;
  CollisionPipeline pipeline;
  std::vector<BodyId> ids;
};
LoadedScene load(Scene scene, const PipelineOptions& options, LogCallback log = {});

/// Returns the options of one detection on the backend under test: `precise`, whatever the type of positions.
PipelineOptions test_options(Detection detection, BroadPhase broad_phase = BroadPhase::exact);

/// The results of a new pipeline's first detection. Throws where another backend than the requested one has run.
struct Outcome {
  std::vector<Contact> contacts;
  Statistics statistics;
  std::vector<StageReport> report;
};
Outcome outcome_of(const Scene& scene, const PipelineOptions& options, const PairFilter& pair_filter = {});

/// Returns its contacts.
std::vector<Contact> detect_once(const Scene& scene, const PipelineOptions& options,
                                 const PairFilter& pair_filter = {});

FeaturePair features_of(const Contact& contact);
std::vector<FeaturePair> features_of(Span<const Contact> contacts);

/// Returns whether all bytes are the same; contacts have no padding.
bool identical(Span<const Contact> a, Span<const Contact> b);

}  // namespace softcd::test

#pragma once

#include <vector>

#include "body.hpp"

namespace softcd {

class SceneLayout;

/// The features of neighbouring triangles, which share a vertex: for each kind, one list of all bodies. All functions
/// keep BodyNeighbours, which describes each body's part, up to date. Owned by SceneStore.
class NeighbourLists {
 public:
  /// Follows bodies that were moved in the scene's arrays. Lists again the features that belong to the changed
  /// triangles of a ChangingMesh; forgets all of the body's if its slots do not suffice. Throws std::bad_alloc; the
  /// next call continues.
  void update(std::vector<Body>& bodies);
  /// Lists the features of all bodies that collide with themselves, and drops forgotten ones. Bodies and lists must be
  /// up to date. Throws std::bad_alloc; the next call continues.
  void list_missing(SceneLayout& layout);

  /// See SceneArrays.
  Span<const std::uint64_t> vertex_triangle() const { return vertex_triangle_.features; }
  Span<const std::uint64_t> edge_edge() const { return edge_edge_.features; }
  Span<const VertexStar> stars() const { return stars_.features; }
  /// Appends the ranges that changed since forget_changes(); if `all`, the whole lists.
  void append_changes(SceneChanges& changes, bool all) const;
  void forget_changes() noexcept;

 private:
  template <class Feature>
  struct List {
    ListedFeatures BodyNeighbours::*part;
    std::vector<Feature> features{};
    UnsentRanges unsent{};

    void renumber(Body& body, std::uint64_t numbering);
    void close_gaps(std::vector<Body>& bodies);
    void append(BodyNeighbours& body, const std::vector<Feature>& added, std::uint64_t numbering);
    FeaturePart part_of(const Body& body);
  };

  List<std::uint64_t> vertex_triangle_{&BodyNeighbours::vertex_triangle};
  List<std::uint64_t> edge_edge_{&BodyNeighbours::edge_edge};
  List<VertexStar> stars_{&BodyNeighbours::stars};
};

}  // namespace softcd

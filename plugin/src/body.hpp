#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "body_positions.hpp"
#include "feature_slots.hpp"
#include "softcd/mesh/changing_mesh.hpp"
#include "softcd/mesh/topology.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/scene.hpp"
#include "unsent_ranges.hpp"

namespace softcd {

/// The present and the planned place of a body's vertices, triangles or edges in the scene's arrays.
struct Place {
  std::uint32_t first = 0, count = 0;
  std::uint32_t capacity = 0;  ///< elements behind the first `count` are unused
  std::uint32_t next_first = 0, next_capacity = 0;

  bool is_outgrown() const { return next_capacity > capacity; }
  Range range() const { return {first, std::uint64_t{first} + capacity}; }
};

/// The parts of a body's arrays that a detector with a copy does not have yet.
struct Unsent {
  bool mesh = false;
  bool ownership = false;
  bool x_t0 = false;
  bool x_t1 = false;
  UnsentRanges triangles, edges;  ///< of the mesh, counted from the body's first element
};

/// Extra data of a body whose triangles are changed a few at a time.
struct ChangingBody {
  explicit ChangingBody(const Topology& topology) : mesh(topology) {}

  ChangingMesh mesh;    ///< the mesh that the scene's arrays will have once they are up to date
  bool is_new = false;  ///< must be written to the scene's arrays as a whole
};

/// A body's part of the scene's list of one kind of features. Adding `numbering` to a feature's number in the mesh
/// gives its number here.
struct ListedFeatures {
  Range range{0, 0};
  std::uint64_t numbering = 0;
};

/// The features of a body's triangles that share a vertex, for one mesh and one ownership.
struct BodyNeighbours {
  struct Slots {
    FeatureSlots vertex_triangle, edge_edge;
  };

  bool are_known = false;   ///< they are listed, or are too many to be listed
  bool are_listed = false;  ///< by NeighbourLists
  ListedFeatures vertex_triangle, edge_edge;
  ListedFeatures stars;          ///< none of bodies whose triangles are changed
  std::unique_ptr<Slots> slots;  ///< of the listed features, for bodies whose triangles are changed; else null
};

/// The scene's record of a body. Its mesh and positions are in the scene's arrays.
struct Body {
  BodyId id;
  bool is_removed = false;  ///< only its place remains
  bool is_placed = false;   ///< has a place in the scene's arrays; bodies without one come last
  BodySettings settings;
  std::int32_t rank = -1;                  ///< see BodyDesc
  std::optional<Topology> new_mesh;        ///< to be written to the scene's arrays; excludes `changing`
  std::unique_ptr<ChangingBody> changing;  ///< null unless triangles were changed since the last new mesh
  Place vertices, triangles, edges;
  Place patches;                    ///< in units of triangles of patches; all of its capacity is used
  std::uint32_t segment_count = 0;  ///< number of segments; they are the last of the placed triangles
  BodyPositions positions;

  /// Vertices that are not finite at the times that the next detection uses, ascending. Their triangles are left out.
  std::vector<std::uint32_t> stray_vertices;
  /// Stray vertices that warnings have reported since the body last had none, ascending.
  std::vector<std::uint32_t> named_strays;
  std::uint64_t left_out_triangles = 0;

  BodyNeighbours neighbours;

  std::vector<VertexFilter> vertex_filters;  ///< none, or one for each vertex
  std::vector<Vec3f> x_rest;                 ///< none, or one for each vertex; see FeatureFilters

  std::optional<bool> is_closed;  ///< for the mesh without left out triangles; computed on demand

  Unsent unsent;
  std::uint64_t last_change = 0;  ///< number of the scene's last change that changed the body

  bool is_new() const { return new_mesh || (changing && changing->is_new); }
  /// Returns the mesh; null where it is only in the scene's arrays.
  const Topology* mesh() const { return new_mesh ? &*new_mesh : changing ? &changing->mesh.topology() : nullptr; }
  std::uint32_t vertex_count() const { return mesh() != nullptr ? mesh()->vertex_count : vertices.count; }
  std::uint64_t triangle_count() const { return mesh() != nullptr ? mesh()->triangles.size() : triangles.count; }
  bool has_segments() const { return (mesh() != nullptr ? mesh()->segment_count : segment_count) > 0; }
  /// Returns the number of edges of triangles and segments.
  std::uint64_t edge_count() const {
    if (changing) return changing->mesh.edge_count();
    return new_mesh ? new_mesh->edges.size() : edges.count;
  }
  bool is_outgrown() const {
    return vertices.is_outgrown() || triangles.is_outgrown() || edges.is_outgrown() || patches.is_outgrown();
  }
  bool excludes_rings() const { return settings.self_collision && settings.neighbour_rings > 1; }
  bool excludes_at_rest() const { return settings.self_collision && settings.rest_distance > 0.0F; }
};

}  // namespace softcd

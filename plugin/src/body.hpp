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

/// Where a body's vertices, triangles or edges are in the scene's arrays, and where they will be.
struct Place {
  std::uint32_t first = 0, count = 0;
  std::uint32_t capacity = 0;  ///< behind the first `count` there is nothing
  std::uint32_t next_first = 0, next_capacity = 0;

  bool is_outgrown() const { return next_capacity > capacity; }
  Range range() const { return {first, std::uint64_t{first} + capacity}; }
};

/// What of a body's part of the scene's arrays a detector elsewhere does not know.
struct Unsent {
  bool mesh = false;
  bool ownership = false;
  bool x_t0 = false;
  bool x_t1 = false;
  UnsentRanges triangles, edges;  ///< of the mesh, counted from the body's first
};

/// What is kept of a body whose triangles are changed a few at a time.
struct ChangingBody {
  explicit ChangingBody(const Topology& topology) : mesh(topology) {}

  ChangingMesh mesh;    ///< as it will be once the scene's arrays are up to date
  bool is_new = false;  ///< to be put into the scene's arrays as a whole
};

/// A body's part of the scene's list of one kind of features. Its features' numbers are those in the mesh, and
/// `numbering` more.
struct ListedFeatures {
  Range range{0, 0};
  std::uint64_t numbering = 0;
};

/// What is known of the features of a body's triangles that share a vertex; for one mesh and one ownership.
struct BodyNeighbours {
  struct Slots {
    FeatureSlots vertex_triangle, edge_edge;
  };

  bool are_known = false;   ///< listed, or too many to be listed
  bool are_listed = false;  ///< by NeighbourLists
  ListedFeatures vertex_triangle, edge_edge;
  std::unique_ptr<Slots> slots;  ///< of the listed features, where triangles are changed; else null
};

/// A body as the scene keeps it; its mesh and positions are in the scene's arrays.
struct Body {
  BodyId id;
  bool is_removed = false;  ///< only its place is left
  bool is_placed = false;   ///< in the scene's arrays; bodies that are not come after all that are
  BodySettings settings;
  std::int32_t rank = -1;                  ///< see BodyDesc
  std::optional<Topology> new_mesh;        ///< to be put into the scene's arrays; nothing is changing then
  std::unique_ptr<ChangingBody> changing;  ///< null where no triangles were changed since there was a new mesh
  Place vertices, triangles, edges;
  std::uint32_t segment_count = 0;  ///< of the triangles that are placed, the last ones
  BodyPositions positions;

  /// Not finite where the detection that was prepared last looks, ascending; their triangles are left out.
  std::vector<std::uint32_t> stray_vertices;
  std::vector<std::uint32_t> named_strays;  ///< of these since there were none, ascending: in warnings
  std::uint64_t left_out_triangles = 0;

  BodyNeighbours neighbours;

  std::vector<VertexFilter> vertex_filters;  ///< none, or one for each vertex
  std::vector<Vec3f> x_rest;                 ///< the same; see FeatureFilters

  std::optional<bool> is_closed;  ///< of the mesh with its left out triangles, where somebody has asked

  Unsent unsent;
  std::uint64_t last_change = 0;  ///< of the scene's changes, in which somebody changed the body

  bool is_new() const { return new_mesh || (changing && changing->is_new); }
  /// Null where the mesh is in the scene's arrays alone.
  const Topology* mesh() const { return new_mesh ? &*new_mesh : changing ? &changing->mesh.topology() : nullptr; }
  std::uint32_t vertex_count() const { return mesh() != nullptr ? mesh()->vertex_count : vertices.count; }
  std::uint64_t triangle_count() const { return mesh() != nullptr ? mesh()->triangles.size() : triangles.count; }
  bool has_segments() const { return (mesh() != nullptr ? mesh()->segment_count : segment_count) > 0; }
  /// That triangles have, or are segments.
  std::uint64_t edge_count() const {
    if (changing) return changing->mesh.edge_count();
    return new_mesh ? new_mesh->edges.size() : edges.count;
  }
  bool is_outgrown() const { return vertices.is_outgrown() || triangles.is_outgrown() || edges.is_outgrown(); }
  bool excludes_rings() const { return settings.self_collision && settings.neighbour_rings > 1; }
  bool excludes_at_rest() const { return settings.self_collision && settings.rest_distance > 0.0F; }
};

}  // namespace softcd

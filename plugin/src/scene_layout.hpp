#pragma once

#include <array>
#include <vector>

#include "body.hpp"
#include "host_array.hpp"

namespace softcd {

/// The numbers of bodies and of their elements.
struct SceneSize {
  std::uint64_t bodies = 0, triangles = 0, vertices = 0, edges = 0, left_out_triangles = 0;
  std::uint64_t bodies_without_positions = 0;
};

/// The bodies of a scene, and the arrays in which each has a place: meshes, and memory for positions. A body keeps its
/// place until it outgrows it. Functions that change a mesh record the change and reserve its memory;
/// apply_changes() changes the arrays. Owned by SceneStore.
class SceneLayout {
 public:
  /// Adds a body with its settings, and throws InvalidInput if the scene would be too large. This function and the next
  /// two change nothing when they throw, and need valid descriptions.
  Body& add_body(const BodyDesc& desc);
  /// Replaces the mesh.
  void set_mesh(Body& body, const BodyDesc& desc);
  /// Replaces some triangles, see Scene::update_body; the body and `desc` have no segments.
  void change_mesh(Body& body, const BodyDesc& desc, Span<const std::uint32_t> changed);
  /// Returns the mesh as change_mesh() will change it.
  const ChangingMesh& changing_mesh(Body& body);
  /// Removes the body's mesh. Its place stays until bodies are moved.
  void remove_body(Body& body);
  /// Returns null if there is no such body, or it was removed.
  Body* find(BodyId id);
  /// The id of the next body that is added.
  BodyId next_id() const { return BodyId{next_id_}; }
  /// Bodies by ascending ids, removed ones included. Their indices here are their numbers in triangle_body and
  /// vertex_body.
  std::vector<Body>& bodies() { return bodies_; }
  const std::vector<Body>& bodies() const { return bodies_; }
  SceneSize size() const;

  /// Makes memory for positions readable by CUDA devices, from now on.
  void share_positions();
  /// Brings the arrays up to date. Nothing may read them during the call. Moves bodies if one has outgrown its place,
  /// or if removed ones take up more than half of the arrays. Throws std::bad_alloc; the next call goes on.
  void apply_changes();
  /// Excludes the triangles with one of these vertices, instead of those that were excluded before. They own nothing;
  /// their other vertices and edges pass to neighbours.
  void leave_out(Body& body, std::vector<std::uint32_t> strays);
  /// Fills Body::is_closed of all that have a place.
  void find_closed_surfaces();

  /// The mesh in the scene's arrays, with their indices, and what its triangles own.
  MeshView mesh_of(const Body& body) const;
  Span<const Ownership> ownership_of(const Body& body) const {
    return {ownership_.data() + body.triangles.first, body.triangles.count};
  }
  /// Returns the arrays into which ScenePositions writes the body's positions.
  PositionArrays positions_of(const Body& body);
  std::size_t vertex_count() const { return vertex_body_.size(); }
  /// Changes with meshes and with what their triangles own.
  std::uint64_t revision() const { return revision_; }
  /// The arrays of this class; others are empty.
  SceneArrays arrays() const;
  /// Appends the ranges of meshes and ownership that changed since forget_changes(); if `all`, everything.
  void append_changes(SceneChanges& changes, bool all) const;
  void forget_changes();

 private:
  /// The kinds of elements of the arrays.
  static constexpr std::size_t kVertices = 0, kTriangles = 1, kEdges = 2, kPatches = 3;
  static constexpr std::array<Place Body::*, 4> kPlaces = {&Body::vertices, &Body::triangles, &Body::edges,
                                                           &Body::patches};
  using Sizes = std::array<std::uint64_t, kPlaces.size()>;

  struct MeshSize {
    std::uint64_t vertices, triangles, edges;
  };

  /// Calls f(array, kind) for every array in which bodies have places.
  template <class F>
  void for_each_array(const F& f);
  void reserve(const Sizes& sizes);
  void plan(Body& body, const MeshSize& size, const PatchOrder& patches);
  Topology copy_of_mesh(const Body& body) const;

  void lay_out() noexcept;
  bool has_to_move() const;
  void choose_places(bool moves);
  template <class T>
  void move_elements(HostArray<T>& elements, std::size_t kind);
  void renumber(std::uint32_t index);
  void fill_rest(std::uint32_t index);
  void place_mesh(std::uint32_t index);
  void place_patches(const Body& body, const PatchOrder& order);
  void write_changes(Body& body);

  std::vector<Body> bodies_;
  std::uint32_t next_id_ = 0;
  std::uint64_t revision_ = 0;
  Sizes planned_{};  ///< of the arrays, once everything has its place
  bool has_new_layout_ = false;
  HostArray<Vec3f> x_t0_, x_t1_;  ///< written by ScenePositions
  HostArray<Triangle> triangles_;
  HostArray<TriangleEdges> triangle_edges_;
  HostArray<Edge> edges_;
  HostArray<Ownership> ownership_;
  HostArray<std::uint32_t> patch_triangles_;
  HostArray<std::uint32_t> triangle_body_, vertex_body_;
};

}  // namespace softcd

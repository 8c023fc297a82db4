#pragma once

#include <vector>

#include "body.hpp"
#include "filter_store.hpp"
#include "foresight.hpp"
#include "host_array.hpp"
#include "softcd/pipeline/detector.hpp"

namespace softcd {

/// What a scene's queries look at, beside t1.
struct LookedAt {
  bool t0 = false;     ///< contacts there, or on the way from there
  bool t1 = false;     ///< contacts there, or on the way to there
  bool moves = false;  ///< how far vertices move from one to the other

  bool needs_t0() const { return t0 || moves; }
  bool needs_t1() const { return t1 || moves; }

  friend bool operator==(const LookedAt&, const LookedAt&) = default;
};

/// How many bodies, and elements of theirs.
struct SceneSize {
  std::uint64_t bodies = 0, triangles = 0, vertices = 0, edges = 0, left_out_triangles = 0;
  std::uint64_t bodies_without_positions = 0;
};

/// The bodies of a scene, and all their meshes and positions, once, in arrays that detectors read. Mutators note what
/// is to change, and take the memory that it needs; settle() changes the arrays.
class SceneStore {
 public:
  BodyId add_body(const BodyDesc& desc);
  void update_body(Body& body, const BodyDesc& desc);
  /// See Scene::update_body; nothing is wrong with what was given.
  void update_body(Body& body, const BodyDesc& desc, Span<const std::uint32_t> changed);
  /// The body's mesh, ready to be changed.
  const ChangingMesh& changing_mesh(Body& body);
  void set_settings(Body& body, const BodySettings& settings);
  void remove_body(Body& body);
  void set_vertex_filters(Body& body, Span<const VertexFilter> filters);
  void set_rest_positions(Body& body, const Positions& x);
  /// Pairs that stop being ignored count as changed. All bodies are there.
  void set_ignored_pairs(BodyPairList pairs);
  const BodyPairList& ignored_pairs() const { return ignored_pairs_; }
  void set_positions(Body& body, const Positions& x_t0, const Positions& x_t1);
  /// Null where there is none, or was removed.
  Body* find(BodyId id);
  /// The id of the next body that is added.
  BodyId next_id() const { return BodyId{next_id_}; }
  /// From now on memory for positions is a CUDA device's, too.
  void share_positions() {
    x_t0_.share();
    x_t1_.share();
    full_t0_.share();
    full_t1_.share();
  }

  bool has_positions_on_device() const;
  /// Whether some of them are doubles that nobody has looked at.
  bool has_new_doubles_on_device() const;

  /// Brings the arrays up to date; nothing reads them meanwhile. How far away the scene is counts where any of its
  /// queries looks, where vertices are not finite where the next detection does. Whatever is thrown, the caller's
  /// memory is not needed afterwards, and the next call goes on. `reader` where there are positions on a device: they
  /// are not in the arrays, but are among changes(). Where it `may_foresee`, their surveys may be what was foreseen:
  /// judge_foreseen() then has to follow before anything else is changed. Detections need lists of neighbours.
  void settle(const LookedAt& by_scene, const LookedAt& by_next, DevicePositionReader* reader, bool may_foresee,
              bool lists_neighbours);
  /// Whether the last settle() has foreseen what it did not wait for.
  bool has_foreseen() const { return !foreseen_blocks_.empty(); }
  /// Once a detector that was told changes() has finished: whether what it was told was so. Else the next settle()
  /// looks anew. Throws what the reader does, as if it was not.
  bool judge_foreseen(DevicePositionReader& reader);
  /// As if it was not so.
  void doubt_foreseen() noexcept;
  /// Another one where pairs of bodies may be others than they were; 0 where that is not known.
  std::uint64_t selection_number() const { return selection_number_; }
  /// Brings positions on a device into the arrays, as if they had been given on the host.
  void take_to_host(DevicePositionReader& reader);
  /// The bodies with vertices that are not finite, and were not said to be before the last settle().
  const std::vector<const Body*>& newly_left_out() const { return newly_left_out_; }

  /// Ascending ids, removed ones included: their places here are their numbers in triangle_body and vertex_body.
  const std::vector<Body>& bodies() const { return bodies_; }
  SceneArrays arrays() const;
  SceneSize size() const;
  Vec3d origin() const { return origin_; }
  /// Another one where meshes, what their triangles own, or positions have changed; never 0.
  std::uint64_t revision() const { return 1 + mesh_revision_ + position_revision_; }
  /// Of all positions at one end.
  Extent extent_at(bool t0) const;
  /// Fills Body::is_closed of all that have a place.
  void find_closed_surfaces();
  /// Changes of bodies are counted, see Body::last_change.
  std::uint64_t last_change() const { return last_change_; }

  /// Fills full_t0 and full_t1 of arrays(), once they are settled, but for positions on a device. Returns another
  /// number where something of them has changed; never 0.
  std::uint64_t fill_full_positions();
  /// All of these, for a detector that does not know them.
  void append_full_positions(SceneChanges& changes) const;

  /// What was changed since a detector was told, x_t0 where `with_t0`; everything, where `all`.
  SceneChanges changes(bool all, bool with_t0) const;
  /// It was told changes().
  void forget_changes(bool with_t0);

 private:
  struct Sizes {
    std::uint64_t vertices, triangles, edges;
  };
  /// What an array has an element for each of.
  struct Kind {
    Place Body::*place;
    std::uint64_t Sizes::*size;
  };
  /// A run of one body's vertices, the unit of parallel work.
  struct Block {
    Body* body;
    std::size_t begin, end;
  };

  /// Calls f(array, kind) for every array in which bodies have places.
  template <class F>
  void for_each_array(const F& f);
  void reserve(const Sizes& sizes);
  void resize(const Sizes& sizes) noexcept;
  void plan(Body& body, std::size_t vertices, std::size_t triangles, std::size_t edges);
  void replace(Body& body, const BodyDesc& desc);
  void change(Body& body) {
    body.last_change = ++last_change_;
    foresight_.forget();
  }

  void lay_out();
  bool has_to_move() const;
  void sweep_out_removed();
  void choose_places(bool moves);
  template <class T>
  void move_elements(HostArray<T>& elements, Place Body::*place);
  void renumber(std::uint32_t index);
  void fill_rest(std::uint32_t index);
  void place_mesh(std::uint32_t index);
  Topology copy_of_mesh(const Body& body) const;
  void settle_changes();
  void settle_changes(Body& body);
  void settle_neighbours();
  bool settle_neighbours(Body& body);
  NeighbourFeatures listed_neighbours(Body& body) const;

  MeshView mesh_of(const Body& body) const;
  PositionArrays positions_of(const Body& body);
  Extent extent(bool t0) const;
  void read_positions(const LookedAt& looked_at, DevicePositionReader* reader);
  bool can_foresee(const LookedAt& looked_at) const;
  void foresee(const LookedAt& looked_at, DevicePositionReader& reader);
  void read_new_positions(Vec3d origin, bool needs_t0);
  void read_in_parallel(Vec3d origin, bool needs_t0);
  static void append_blocks(Body& body, std::vector<Block>& blocks);
  static void wait_until_ready(const Body& body, DevicePositionReader& reader);
  static std::vector<SurveyedVertices> surveyed(const std::vector<Block>& blocks);
  static void merge_surveys(const std::vector<Block>& blocks, Span<const StepSurvey> surveys);
  bool lacks_t0(const Body& body) const;
  void finish_reading(Body& body, Vec3d origin);
  template <class IsConcerned>
  void survey_device_bodies(DevicePositionReader& reader, Vec3d origin, const IsConcerned& is_concerned);
  void take_to_host(Body& body, DevicePositionReader& reader);
  void take_strays_to_host(DevicePositionReader& reader);
  void copy_full_positions(const Block& block);

  std::vector<std::uint32_t> strays_of(const Body& body, const LookedAt& looked_at) const;
  void leave_out_strays(const LookedAt& looked_at);
  void name_strays(Body& body, const std::vector<std::uint32_t>& strays);
  void leave_out(Body& body, std::vector<std::uint32_t> strays);
  void drop_neighbours(Body& body);
  void forget_dropped_neighbours();
  void list_neighbours();

  std::vector<Body> bodies_;
  std::uint32_t next_id_ = 0;
  std::uint64_t last_change_ = 0;
  std::uint64_t mesh_revision_ = 0;
  std::uint64_t position_revision_ = 0;
  Sizes planned_{0, 0, 0};  ///< of the arrays, once everything has its place
  bool has_new_layout_ = false;
  Vec3d origin_{0, 0, 0};
  bool needs_t0_ = false;  ///< the queries did, when positions were read last
  LookedAt looked_at_;     ///< by them
  Foresight foresight_;
  std::vector<Block> foreseen_blocks_;  ///< whose surveys are foreseen; bodies stay where they are meanwhile
  ForeseenVerdict verdict_;             ///< on them
  // Of the last settle() that has foreseen, while there is no other:
  std::uint64_t foreseen_number_ = 0;         ///< of what was
  std::vector<std::size_t> foreseen_bodies_;  ///< whose positions were
  std::uint64_t selection_number_ = 0, last_selection_number_ = 0;
  HostArray<Vec3f> x_t0_, x_t1_;
  HostArray<Vec3d> full_t0_, full_t1_;  ///< of this revision():
  std::uint64_t full_revision_ = 0;
  HostArray<Triangle> triangles_;
  HostArray<TriangleEdges> triangle_edges_;
  HostArray<Edge> edges_;
  HostArray<Ownership> ownership_;
  HostArray<std::uint32_t> triangle_body_, vertex_body_;
  std::vector<std::uint64_t> vertex_triangle_neighbours_, edge_edge_neighbours_;
  bool has_dropped_neighbours_ = false;
  UnsentRanges unsent_vertex_triangle_neighbours_, unsent_edge_edge_neighbours_;
  std::vector<const Body*> newly_left_out_;
  FilterStore filters_;
  BodyPairList ignored_pairs_;
};

}  // namespace softcd

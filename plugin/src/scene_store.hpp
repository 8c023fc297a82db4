#pragma once

#include "body_pair_list.hpp"
#include "filter_store.hpp"
#include "neighbour_lists.hpp"
#include "scene_layout.hpp"
#include "scene_positions.hpp"

namespace softcd {

/// The bodies of a scene, and all data of them that detectors read. Functions that change a body record the change and
/// reserve its memory. apply_changes() then updates the layout, the positions, the lists of neighbours and the filters,
/// in this order. Owned by SceneCore.
class SceneStore {
 public:
  SceneStore() = default;
  SceneStore(const SceneStore&) = delete;
  SceneStore& operator=(const SceneStore&) = delete;

  /// Implement Scene's functions of these names, for valid arguments. They change nothing when they throw.
  BodyId add_body(const BodyDesc& desc);
  void update_body(Body& body, const BodyDesc& desc);
  void update_body(Body& body, const BodyDesc& desc, Span<const std::uint32_t> changed);
  void set_settings(Body& body, const BodySettings& settings);
  void remove_body(Body& body);
  void set_vertex_filters(Body& body, Span<const VertexFilter> filters);
  void set_rest_positions(Body& body, const Positions& x);
  void set_positions(Body& body, const Positions& x_t0, const Positions& x_t1);
  /// Sets the ignored pairs. Pairs that are no longer ignored count as changed. All bodies must exist.
  void set_ignored_pairs(BodyPairList pairs);
  const BodyPairList& ignored_pairs() const { return ignored_pairs_; }

  SceneLayout& layout() { return layout_; }
  ScenePositions& positions() { return positions_; }
  const SceneLayout& layout() const { return layout_; }
  const ScenePositions& positions() const { return positions_; }
  const std::vector<Body>& bodies() const { return layout_.bodies(); }
  /// Returns a number that changes with meshes, ownership and positions; never 0.
  std::uint64_t revision() const { return 1 + layout_.revision() + positions_.revision(); }
  /// Returns the number of changes of bodies, see Body::last_change.
  std::uint64_t last_change() const { return last_change_; }

  /// Brings the arrays up to date. Nothing may read them during the call. `by_scene` has the ends that all queries
  /// need, which decide the origin. `by_next` has those of the next detection, at which vertices have to be finite.
  /// `lists_neighbours` is for detections. See ScenePositions::read() for `reader`, `may_predict` and errors.
  void apply_changes(const NeededPositions& by_scene, const NeededPositions& by_next, DevicePositionReader* reader,
                     bool may_predict, bool lists_neighbours);
  SceneArrays arrays() const;
  /// Returns what has changed since forget_changes(), x_t0 if `with_t0`; if `all`, everything.
  SceneChanges changes(bool all, bool with_t0) const;
  /// Records that a detector has received changes().
  void forget_changes(bool with_t0);

 private:
  void replace(Body& body, const BodyDesc& desc);
  void note_change(Body& body);
  void leave_out_strays(const NeededPositions& needs);

  SceneLayout layout_;
  ScenePositions positions_{layout_};
  NeighbourLists neighbours_;
  FilterStore filters_;
  BodyPairList ignored_pairs_;
  std::uint64_t last_change_ = 0;
};

}  // namespace softcd

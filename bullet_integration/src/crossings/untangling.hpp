#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "bodies/guarded.hpp"
#include "contacts/tangles.hpp"
#include "crossings/way_out.hpp"
#include "softcd/bullet/world_detection.hpp"

namespace softcd::bullet {

/// Moves intersecting soft bodies apart (Settings::untangle). At the start of a step, find() asks for the regions of
/// their surfaces on the wrong side; see Probe::intersection_regions(). Contacts and prevention of crossings then
/// release the nodes at them, because these would keep the nodes where they are. At the end, move() moves the nodes.
///
/// Pairs of bodies are searched when a body is new or has other faces, and in one step of kStepsBetweenSearches. In
/// between only pairs are looked at that intersect, or that did so in this number of steps.
class Untangling {
 public:
  using Kind = CrossingsOfKind;

  /// A search costs about as much as a detection of contacts. So a world without intersections hardly notices it.
  static constexpr std::uint64_t kStepsBetweenSearches = 32;

  /// `kind`, `mirror` and `settings` must outlive it.
  Untangling(const CrossingsOfKind& kind, WorldMirror& mirror, const Settings& settings);
  Untangling(const Untangling&) = delete;
  Untangling& operator=(const Untangling&) = delete;

  /// Throws InvalidInput for a speed out of range.
  void follow_settings();
  std::vector<StageReport> explain() const { return {}; }

  /// Finds the regions of the bodies that are in the mirror, at the step's start. Pairs are those of the rule, and
  /// bodies that collide with themselves.
  void find(Span<btSoftBody* const> bodies, const PairRule& rule);
  /// Forgets the regions.
  void clear();
  /// Moves the nodes, and keeps their bodies awake.
  void move(btScalar time_step);

  /// Returns whether move() changes the body.
  bool moves(const btSoftBody& body) const;
  /// Returns the nodes that get no contacts with the bodies that they intersect.
  const TangledNodes& nodes() const { return nodes_; }
  /// Returns the intersecting pairs of bodies, in the order of their ids.
  const std::vector<IntersectingBodies>& pairs() const { return pairs_; }

 private:
  struct Pair {
    ProbeBodies bodies;
    std::uint64_t steps = 0;        ///< in which it intersected, since it was found
    std::uint64_t clean_steps = 0;  ///< since then
  };

  void search(Span<btSoftBody* const> bodies, const PairRule& rule);
  void find_ways(Pair pair);
  void lead_to_faces(BodyId other, const std::vector<std::pair<WayOut, ProbePoint>>& ways);
  WayOut way_of_edges(const IntersectionRegions& found, const IntersectionCurve& curve) const;
  void release_curves(const IntersectionRegions& found);
  void note_end(const Pair& pair) const;

  const CrossingsOfKind& kind_;
  WorldMirror& mirror_;
  const Settings& settings_;
  Probe probe_;
  std::uint64_t step_ = 0;
  std::vector<Pair> known_;  ///< by ids
  std::vector<IntersectingBodies> pairs_;
  TangledNodes nodes_;
  std::vector<WayOut> ways_;
};

}  // namespace softcd::bullet

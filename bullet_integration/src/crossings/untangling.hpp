#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bodies/body_key.hpp"
#include "bodies/guarded.hpp"
#include "contacts/tangles.hpp"
#include "crossings/way_out.hpp"
#include "softcd/bullet/world_detection.hpp"

namespace softcd::bullet {

/// Moves soft bodies apart that intersect each other, themselves or rigid triangle meshes (Settings::untangle). At the
/// start of a step, find() and find_in_meshes() ask for the regions of their surfaces on the wrong side; see
/// Probe::intersection_regions(). Contacts and prevention of crossings then release the nodes at them, because these
/// would keep the nodes where they are. At the end, move() moves the nodes. All pairs of bodies are searched when a
/// body is new or has other faces, and in one step of kStepsBetweenSearches. In between only pairs are searched that
/// had tangled contacts in the step before, that intersect, or did so within kStepsOfAttempt: what comes apart at a
/// blow may at once meet again. A pair whose way out becomes no shorter is left alone for a while, which doubles each
/// time. So what cannot come apart, such as a crumpled heap, takes little time and may fall asleep. Owned by
/// WorldQueries.
class Untangling {
 public:
  using Kind = CrossingsOfKind;

  /// A search costs about as much as a detection of contacts, which is little if it runs in one step of so many.
  static constexpr std::uint64_t kStepsBetweenSearches = 32;
  /// A pair is given up for a while if so many steps have not brought it nearer to its way out. A pair that has not
  /// intersected in so many steps is forgotten.
  static constexpr std::uint64_t kStepsOfAttempt = 8;

  /// `kind`, `mirror` and `settings` must outlive it.
  Untangling(const CrossingsOfKind& kind, WorldMirror& mirror, const Settings& settings);
  Untangling(const Untangling&) = delete;
  Untangling& operator=(const Untangling&) = delete;

  /// Throws InvalidInput for a speed out of range.
  void follow_settings();
  std::vector<StageReport> explain() const { return {}; }

  /// Forgets the regions of the last step.
  void begin_step();
  /// Finds the regions of the bodies that are in the mirror, at the step's start. Pairs are those of the rule, and
  /// bodies that collide with themselves. `tangled` are pairs that the contacts of the last step have seen intersect.
  void find(Span<btSoftBody* const> bodies, const PairRule& rule, Span<const ProbeBodies> tangled);
  /// Searches for pairs that intersect. Returns whether it has found new ones, whose meshes must be read wholly.
  bool search_in_meshes(Span<const NearRigidPart> near_parts);
  /// Finds the regions of these pairs. Their meshes are read wholly, because only a whole mesh can be closed.
  void find_in_meshes(Span<const NearRigidPart> near_parts);
  /// Returns whether the pair intersects, or did so within kStepsOfAttempt.
  bool knows(const btSoftBody& soft, BodyId part) const;
  /// Forgets the regions and the pairs.
  void clear();
  /// Moves nodes and rigid bodies, and keeps them awake. `objects` are the world's.
  void move(const btCollisionObjectArray& objects, btScalar time_step);

  /// Returns whether move() changes the body.
  bool moves(const btSoftBody& body) const;
  /// Returns the nodes that get no contacts with the bodies that they intersect.
  const TangledNodes& nodes() const { return nodes_; }
  /// Returns the impulses of move(), with ReadOut::impulses.
  const std::vector<CrossingImpulse>& impulses() const { return impulses_; }
  /// Returns the intersecting pairs of bodies, in the order of their ids.
  const std::vector<IntersectingBodies>& pairs() const { return pairs_; }

 private:
  struct Pair {
    ProbeBodies bodies;
    bool is_from_start = false;      ///< whether it intersected when one of the bodies was new
    std::uint64_t steps = 0;         ///< in which it intersected, since it was found
    std::uint64_t clean_steps = 0;   ///< since then
    std::uint64_t attempt_step = 0;  ///< in the present attempt, from 0
    double way_at_attempt = 0;       ///< the length of the way out when the attempt began
    unsigned vain_attempts = 0;      ///< one after another
    std::uint64_t resumes_at = 0;    ///< the first step of the next attempt
    std::uint64_t moved_at = 0;      ///< the last step with ways out
  };

  struct Candidate {
    ProbeBodies bodies;
    bool is_from_start;  ///< whether one of the bodies is new, so that the app has placed them as they are
  };

  Probe& probe();
  bool is_search_step() const { return step_ % kStepsBetweenSearches == 1; }
  bool is_moved(const Pair& pair) const;
  bool is_left_to_app(const Pair& pair) const;
  bool parts_from_start(const Pair& pair) const;
  bool has_filters(const Pair& pair) const;
  bool is_awake(const Pair& pair) const;
  bool was_in_world(const BodyKey& body) const;
  bool is_from_start(const NearRigidPart& part) const;
  void note_end_of_step(const btCollisionObjectArray& objects);
  void judge_attempt(Pair& pair, double way) const;
  void search(Span<btSoftBody* const> bodies, const PairRule& rule);
  void search(Span<const ProbeBodies> tangled);
  bool search(Span<const Candidate> candidates, std::vector<Pair>& known);
  void find_ways(Pair pair, std::vector<Pair>& known);
  void add_way(WayOut way);
  const NearRigidPart* find_part(BodyId id) const;
  const btCollisionObject& object_of(BodyId id) const;
  btScalar margin_of(BodyId id) const;
  Triangle corners_of(BodyId id, std::uint32_t triangle) const;
  Vec3d start_of_node(BodyId id, std::uint32_t node) const;
  void release(BodyId id, std::uint32_t node, BodyId other);
  btScalar speed_of_ways(const IntersectionRegions& found) const;
  void lead_to_faces(BodyId other, const std::vector<std::pair<WayOut, ProbePoint>>& ways);
  WayOut way_of_edges(const IntersectionRegions& found, const IntersectionCurve& curve) const;
  void release(const IntersectionRegions& found, const IntersectionCurve& curve);
  void note_end(const Pair& pair) const;

  const CrossingsOfKind& kind_;
  WorldMirror& mirror_;
  const Settings& settings_;
  std::optional<Probe> probe_;
  std::uint64_t step_ = 0;
  std::vector<Pair> known_;                      ///< of soft bodies, by ids
  std::vector<Pair> known_in_meshes_;            ///< of a soft body and a part of a mesh, by ids
  std::vector<BodyId> seen_;                     ///< soft bodies of the last step
  std::vector<std::pair<BodyId, BodyId>> near_;  ///< soft bodies and parts that are searched already
  std::vector<BodyKey> in_world_;                ///< objects of the world when the last step ended
  /// Soft bodies and objects with meshes that intersected from the start when the last step ended. The parts of meshes
  /// near a sleeping body leave the scene, and are new when it wakes.
  std::vector<std::pair<BodyKey, BodyKey>> from_start_;
  std::unordered_map<std::uint32_t, NearRigidPart> parts_;  ///< of this step, by ids
  std::vector<IntersectingBodies> pairs_;
  TangledNodes nodes_;
  std::vector<WayOut> ways_;
  std::vector<CrossingImpulse> impulses_;
};

}  // namespace softcd::bullet

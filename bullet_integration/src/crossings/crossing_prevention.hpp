#pragma once

#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "bodies/massless_node_paths.hpp"
#include "bodies/query_options.hpp"
#include "contacts/tangles.hpp"
#include "crossings/crossing_impulses.hpp"
#include "crossings/held_nodes.hpp"
#include "crossings/rigid_obstacles.hpp"
#include "crossings/tangled_pairs.hpp"
#include "softcd/bullet/world_detection.hpp"

namespace softcd::bullet {

/// Last pass of a step with continuous detection. Changes the nodes' end positions until no node crosses a face on its
/// straight path. If edge contacts get responses, no edge crosses an edge either. Margins do not count. Rigid triangle
/// meshes are obstacles. Those with mass get the opposite impulses. With discrete detection the pass prevents crossings
/// with obstacles, including those of their edges, and crossings of soft bodies that the pass has moved, with others
/// and with themselves.
///
/// Impulses come first, and in classic worlds a limit on how far these stretch links. Then impact zones move as rigid
/// bodies. Then small gaps separate features that zones leave within the rounding of positions. Nodes that still meet
/// stay where the step began, because nothing crossed anything there. More and more nodes around them stay, until
/// nothing meets. A rigid mesh with mass stays there, too, and stops, if nodes cannot make way for it. Inactive bodies
/// move only if nothing else prevents a crossing. Each later query tests only pairs with a changed body: the other
/// pairs have not moved since they were found free of crossings. Owned by WorldQueries, which calls run() after
/// Bullet's solver.
class CrossingPrevention {
 public:
  using Kind = CrossingsOfKind;

  /// `kind`, `mirror` and `settings` must outlive it.
  CrossingPrevention(const CrossingsOfKind& kind, WorldMirror& mirror, const Settings& settings);
  CrossingPrevention(const CrossingPrevention&) = delete;
  CrossingPrevention& operator=(const CrossingPrevention&) = delete;

  void follow_settings();
  const Query& query() const { return query_; }
  std::vector<StageReport> explain() const { return query_.explain(); }

  /// Saves the nodes' start positions in classic worlds. Call it after Bullet's prediction: if a body is to drift back
  /// (Config::diterations), Bullet's solver overwrites its start positions with its result.
  void keep_starts(Span<btSoftBody* const> bodies);

  /// Saves the poses of rigid meshes. Call it before Bullet moves rigid objects in a step; otherwise their meshes count
  /// as standing where they end.
  void keep_rigid_starts(const btCollisionObjectArray& objects, btScalar time_step) {
    obstacles_.keep_starts(objects, time_step);
  }

  /// Changes m_v and NodeEnds::end. With discrete detection, `bodies` are those near rigid meshes, whatever their
  /// flags. Returns whether there were impacts. If it throws, the nodes keep their motion from before the call.
  /// `released` are nodes that may pass through the bodies with which they are tangled, `moved` those that the app has
  /// moved.
  bool run(Span<btSoftBody* const> bodies, const PairRule& rule, btScalar time_step,
           const Surroundings& surroundings = {}, const TangledNodes* released = nullptr,
           const MasslessNodePaths* moved = nullptr);

  /// Puts nodes exactly where the last run() found no crossings. Call it in the deformable world after Bullet has moved
  /// the nodes: the sum of a node's velocities can round to another place. Does nothing in steps without run().
  void place_ends();

  /// Returns whether run() without bodies would change nothing, because there were none in the last step either.
  bool is_idle() const { return had_no_bodies(query_) && obstacles_.empty(); }

  /// Returns the responses of the last step.
  const CrossingAnswers& answers() const { return answers_; }
  /// Returns the impulses of the last step. Empty without ReadOut::impulses.
  const std::vector<CrossingImpulse>& impulses() const { return impulses_.impulses(); }

 private:
  bool is_released(const MemberContact& found, FirstFan& first) const;
  bool moves_out(const MemberContact& found) const;
  bool is_of_unanswered_link(const MemberContact& found) const;
  bool may_stay(const MemberContact& found) const;
  void require(btSoftBody& body, btScalar time_step);
  bool require(Span<btSoftBody* const> bodies, const Surroundings& surroundings, btScalar time_step);
  bool keeps_apart(btSoftBody& a, btSoftBody& b, const PairRule& rule) const;
  bool keeps_from_itself(BodyId id) const;
  void require_neighbours(Span<btSoftBody* const> moved, btScalar time_step);
  std::vector<Impact> find_impacts(Pairs pairs);
  void restore_start(btSoftBody& body) const;
  void round_ends(btSoftBody& body) const;
  struct Responses;
  void answer(std::vector<Impact> impacts, btScalar time_step);
  std::vector<Impact> respond(std::vector<Impact> impacts, Responses& responses, btScalar time_step);
  bool is_left_to_inactive_bodies(const std::vector<Impact>& impacts) const;
  void take_up(Impact& impact, btScalar time_step);
  void take_up(btSoftBody& body, btScalar time_step);
  void note_meeting(const Impact& impact);
  bool hold_rigid_bodies(const std::vector<Impact>& impacts);
  void take_back() const;
  std::vector<Impact> begin_again();
  bool moves(const Impact& impact) const;
  void update_positions(const HeldNodes& held, btScalar time_step);
  void count_unavoidable(const std::vector<Impact>& impacts);
  void name_new_pairs(Span<btSoftBody* const> bodies) const;

  const CrossingsOfKind& kind_;
  WorldMirror& mirror_;
  const Settings& settings_;
  Query query_;
  std::unordered_map<const btSoftBody*, std::vector<btVector3>> starts_;
  AnsweredBodies answered_;
  ConstrainedNodes constrained_;
  NodeConstraint held_;                  ///< of nodes of inactive bodies, while these stay
  bool do_inactive_bodies_stay_ = true;  ///< in run()
  RigidObstacles obstacles_;
  TangledPairs tangled_;
  const TangledNodes* released_ = nullptr;          ///< in run()
  const MasslessNodePaths* moved_ = nullptr;        ///< in run()
  Span<btSoftBody* const> neighbours_;              ///< in run()
  std::unordered_set<const btSoftBody*> required_;  ///< in this step
  /// Has the nodes' ends of bodies in the deformable world whose velocities do not lead there exactly.
  std::vector<std::pair<btSoftBody*, std::vector<btVector3>>> ends_;
  CrossingAnswers answers_;
  CrossingImpulses impulses_;
};

}  // namespace softcd::bullet

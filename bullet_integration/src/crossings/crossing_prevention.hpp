#pragma once

#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "crossings/crossing_impulses.hpp"
#include "crossings/held_nodes.hpp"
#include "crossings/rigid_obstacles.hpp"
#include "crossings/tangled_pairs.hpp"
#include "softcd/bullet/world_detection.hpp"

namespace softcd::bullet {

/// Of answers to what would meet, after how many rounds the next kind begins: impulses, as often as Bullet's own loop
/// in the deformable world tries; zones; single nodes that are held; then whole bodies, until `last`.
struct AnswerRounds {
  std::uint64_t impulses = 5;
  std::uint64_t zones = 25;
  std::uint64_t nodes = 40;
  std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
};

/// The last word of a step with continuous detection: changes where the nodes are going until no node passes through a
/// face on its straight way (nor an edge through an edge, where edge contacts are responded to). Margins do not count.
/// Rigid triangle meshes are obstacles, which others move. With discrete detection it looks at obstacles alone, at
/// their edges as well. Looks again only at what bodies that it changed may meet: others are where they were when they
/// were found not to. Impulses come first, then zones that move as one, then a
/// little room for what these leave within the rounding of positions; what still meets then stays where the step began,
/// where nothing was through anything else, and more and more around it, until nothing meets.
class CrossingPrevention {
 public:
  using Kind = CrossingsOfKind;

  /// `kind` and `mirror` outlive it.
  CrossingPrevention(const CrossingsOfKind& kind, WorldMirror& mirror, const Settings& settings,
                     const AnswerRounds& rounds = {});
  CrossingPrevention(const CrossingPrevention&) = delete;
  CrossingPrevention& operator=(const CrossingPrevention&) = delete;

  void follow_settings();
  const Query& query() const { return query_; }
  std::vector<StageReport> explain() const { return query_.explain(); }

  /// In classic worlds, when the nodes have been predicted: Bullet's solver puts its own result in place of where a
  /// body started where that is to drift back (Config::diterations).
  void keep_starts(Span<btSoftBody* const> bodies);

  /// Before Bullet moves rigid objects in a step; without it their meshes are where they end.
  void keep_rigid_starts(const btCollisionObjectArray& objects, btScalar time_step) {
    obstacles_.keep_starts(objects, time_step);
  }
  /// Soft bodies of ours that stand for rigid meshes in the mirror.
  Span<btSoftBody* const> stand_ins() const { return obstacles_.stand_ins(); }

  /// Changes m_v and NodeEnds::end. With discrete detection, `bodies` are those near rigid meshes, whatever their
  /// flags. True when anything was changed. When it throws, the nodes go on as they were about to.
  bool run(Span<btSoftBody* const> bodies, const PairRule& rule, btScalar time_step,
           const Surroundings& surroundings = {});

  /// Of the last step.
  const CrossingAnswers& answers() const { return answers_; }
  /// Returns the impulses of the last step. Empty without ReadOut::impulses.
  const std::vector<CrossingImpulse>& impulses() const { return impulses_.impulses(); }

 private:
  bool is_let_go(const MemberContact& found) const;
  bool is_of_unanswered_link(const MemberContact& found) const;
  bool may_stay(const MemberContact& found) const;
  bool require(Span<btSoftBody* const> bodies, const Surroundings& surroundings, btScalar time_step);
  std::vector<Impact> find_impacts(Pairs pairs);
  void restore_start(btSoftBody& body) const;
  void answer(std::vector<Impact> impacts, btScalar time_step);
  void take_up(Impact& impact, btScalar time_step);
  void take_up(btSoftBody& body, btScalar time_step);
  void note_meeting(const Impact& impact);
  void take_back();
  void look_again(const HeldNodes& held, btScalar time_step);
  void count_unavoidable(const std::vector<Impact>& impacts);
  void name_unavoidable(Span<btSoftBody* const> bodies) const;
  void name_let_go(Span<btSoftBody* const> bodies) const;

  const CrossingsOfKind& kind_;
  WorldMirror& mirror_;
  const Settings& settings_;
  AnswerRounds rounds_;
  Query query_;
  std::unordered_map<const btSoftBody*, std::vector<btVector3>> starts_;
  AnsweredBodies answered_;
  ConstrainedNodes constrained_;
  RigidObstacles obstacles_;
  TangledPairs tangled_;
  CrossingAnswers answers_;
  CrossingImpulses impulses_;
};

}  // namespace softcd::bullet

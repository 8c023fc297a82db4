#pragma once

#include <vector>

#include "world_kind.hpp"

namespace softcd::bullet {

/// The last word of a step with continuous detection: changes where the nodes are going until no node passes through a
/// face on its straight way (nor an edge through an edge, where edge contacts are responded to). Margins do not count.
/// Topology and bodies are sent to the detector once a step, positions as often as they change. Looks again only at
/// what bodies that it changed may meet.
class CrossingPrevention {
 public:
  /// `kind` outlives it.
  CrossingPrevention(const WorldKind& kind, const Settings& settings);
  CrossingPrevention(const CrossingPrevention&) = delete;
  CrossingPrevention& operator=(const CrossingPrevention&) = delete;

  void set_settings(const Settings& settings);
  const CollisionPipeline& pipeline() const { return pipeline_; }

  /// Changes m_v and WorldKind::end. True when anything was changed. When it throws, the nodes
  /// go on as they were about to.
  bool run(Span<btSoftBody* const> bodies, const PairRule& rule, btScalar time_step);

 private:
  BodySettings body_settings(const btSoftBody& body) const;
  void synchronize(Span<btSoftBody* const> bodies);
  bool is_let_go(const MemberContact& found) const;
  std::vector<Impact> find_impacts();
  void answer(std::vector<Impact> impacts, btScalar time_step);
  void take_up(btSoftBody& body, btScalar time_step);
  void take_back();
  void set_positions(const btSoftBody& body);
  void look_again(btScalar time_step);

  const WorldKind& kind_;
  Settings settings_;
  CollisionPipeline pipeline_;
  SoftBodyRegistry registry_;
  const PairRule* rule_ = nullptr;
  AnsweredBodies answered_;
};

}  // namespace softcd::bullet

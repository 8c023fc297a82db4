#pragma once

#include <functional>
#include <unordered_map>
#include <vector>

#include "soft_body_registry.hpp"
#include "softcd/bullet/settings.hpp"
#include "velocity_response.hpp"

namespace softcd::bullet {

/// Whether softcd looks after the contacts of two soft bodies.
using PairRule = std::function<bool(btSoftBody&, btSoftBody&)>;

/// The last word of a step with continuous detection: changes where the nodes are going until no node passes through a
/// face on its straight way (nor an edge through an edge, where edge contacts are responded to). Margins do not count.
/// Topology and bodies are sent to the detector once a step, positions as often as they change. Looks again only at
/// what bodies that it changed may meet.
class CrossingPrevention {
 public:
  enum class World : std::uint32_t {
    classic,     ///< nodes have moved from m_q to m_x, VF_SS
    deformable,  ///< nodes are to move from m_x by time_step * (m_v + m_splitv), VF_DD; where to is left in m_q
  };

  CrossingPrevention(World world, const Settings& settings);
  CrossingPrevention(const CrossingPrevention&) = delete;
  CrossingPrevention& operator=(const CrossingPrevention&) = delete;

  void set_settings(const Settings& settings);
  const CollisionPipeline& pipeline() const { return pipeline_; }

  /// Changes m_v, and in the classic world m_x. True when anything was changed.
  bool run(Span<btSoftBody* const> bodies, const PairRule& rule, btScalar time_step);

 private:
  BodySettings body_settings(const btSoftBody& body) const;
  void synchronize(Span<btSoftBody* const> bodies);
  bool is_let_go(const MemberContact& found) const;
  std::vector<Impact> find_impacts();
  void take_up(btSoftBody& body, btScalar time_step);
  void move_end(btSoftBody& body, btScalar time_step) const;
  void set_positions(const btSoftBody& body);
  void look_again(btScalar time_step);
  void answer_own_velocities(const std::vector<Impact>& impacts, ImpactZones& zones);

  World world_;
  Settings settings_;
  CollisionPipeline pipeline_;
  SoftBodyRegistry registry_;
  const PairRule* rule_ = nullptr;
  /// The bodies that have met something in this step, and, in the classic world, their nodes' own velocities.
  std::unordered_map<btSoftBody*, std::vector<btVector3>> answered_;
};

}  // namespace softcd::bullet

#pragma once

#include <vector>

#include "contact_writer.hpp"
#include "crossing_prevention.hpp"
#include "pair_gate.hpp"

namespace softcd::bullet {

/// Finds the vertex-face contacts (VF_DD) of a deformable world's soft bodies: those at the start of a step, when the
/// nodes lie at m_x, and those on the way to where the velocities of the step's end lead.
class DeformableDetection {
 public:
  explicit DeformableDetection(const Settings& settings);
  DeformableDetection(const DeformableDetection&) = delete;
  DeformableDetection& operator=(const DeformableDetection&) = delete;

  const Settings& settings() const { return settings_; }
  void set_settings(const Settings& settings);
  const CollisionPipeline& discrete_pipeline() const { return discrete_; }
  const CollisionPipeline& continuous_pipeline() const { return prevention_.pipeline(); }
  const std::vector<EdgeContact>& edge_contacts() const { return edge_contacts_; }

  /// Appends the contacts at m_x to the bodies' m_faceNodeContacts.
  void find_contacts(Span<btSoftBody* const> bodies, const PairGate& gate);
  /// See CrossingPrevention.
  void prevent_crossings(Span<btSoftBody* const> bodies, const PairGate& gate, btScalar time_step);

 private:
  PairRule pair_rule(const PairGate& gate) const;
  void synchronize(btSoftBody& body);
  void write(const MemberContact& found);

  Settings settings_;
  CollisionPipeline discrete_;
  SoftBodyRegistry registry_;
  CrossingPrevention prevention_;
  const PairRule* rule_ = nullptr;
  std::vector<EdgeContact> edge_contacts_;
};

}  // namespace softcd::bullet

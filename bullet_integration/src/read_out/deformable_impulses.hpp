#pragma once

#include <random>
#include <unordered_map>

#include "contacts/backed_nodes.hpp"
#include "read_out/contact_read_out.hpp"

class btDeformableBodySolver;

namespace softcd::bullet {

/// Measures the impulses of contacts in the deformable world.
///
/// Bullet's constraints store the impulses of contacts with rigid objects. The solver then applies the damping within
/// the soft bodies, while it holds nodes in the directions of their contacts. The contacts resist the damping by a
/// further impulse. It is the change of a node's momentum without the damping's share and without the stored impulses.
/// Owned by WorldReadOut.
class DeformableImpulses {
 public:
  /// Saves the nodes' velocities. Call it right before Bullet's solver.
  void keep_velocities(Span<btSoftBody* const> bodies);
  /// Reads the impulses of contacts with rigid objects. Call it after Bullet's solver, which stores them until the next
  /// step. `bodies` are all of the world's, in its order. Pass 0 as `time_step` if velocities have changed since: the
  /// soft bodies' impulses are then those of the constraints alone.
  void read_rigid(Span<btSoftBody* const> bodies, btScalar time_step);
  /// Does the same, and prepares apply_repulsion().
  void prepare(Span<btSoftBody* const> bodies, btScalar time_step);
  /// Responds to contacts between soft bodies, one at a time. Throws nothing.
  void apply_repulsion(Span<btSoftBody* const> bodies, btScalar time_step, const BackedNodes& backed);

  const ContactImpulses& impulses() const { return impulses_; }

 private:
  void add_reactions(btDeformableBodySolver& solver, Span<btSoftBody* const> bodies, btScalar time_step);

  ContactImpulses impulses_;
  std::unordered_map<const btSoftBody*, std::vector<btVector3>> velocities_;  ///< before Bullet's solver
  std::vector<int> order_;  ///< of all active bodies' contacts, body by body
  std::minstd_rand random_;
};

}  // namespace softcd::bullet

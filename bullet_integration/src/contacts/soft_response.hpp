#pragma once

#include <functional>
#include <random>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/core/span.hpp"

namespace softcd::bullet {

/// Keeps nodes of inactive bodies from being moved by Bullet's response to contacts, while it exists. Bullet would give
/// them velocities, and move them by these, but solve none of their springs.
class InactiveNodesHeld {
 public:
  /// `stays` says which inactive bodies stay where they are in this step. Bullet moves the others by the velocities
  /// that they have. Both arguments must outlive the object.
  InactiveNodesHeld(Span<btSoftBody* const> bodies, const std::function<bool(const btSoftBody&)>& stays);
  ~InactiveNodesHeld();
  InactiveNodesHeld(const InactiveNodesHeld&) = delete;
  InactiveNodesHeld& operator=(const InactiveNodesHeld&) = delete;

 private:
  Span<btSoftBody* const> bodies_;
  const std::function<bool(const btSoftBody&)>& stays_;
};

/// Returns whether a contact's node would pass through its face in this step, with the velocities of now. Looks at the
/// contacts of active bodies in the deformable world.
bool passes_in_contact(Span<btSoftBody* const> bodies, btScalar time_step);

/// Appends 0 to count - 1, shuffled as Bullet does: in the order of detection pushes would add up in one direction.
void append_shuffled(int count, std::minstd_rand& random, std::vector<int>& order);

/// Responds to contacts between soft bodies as Bullet's deformable world does. Calls respond(with_springs) once with
/// springs, then without, as long as a node would pass through a face. Bullet tests all nodes and faces for that, but
/// repeats its response to contacts only.
template <class Respond>
void respond_to_soft_contacts(Span<btSoftBody* const> bodies, btScalar time_step, Respond respond) {
  constexpr int kMostRepeats = 5;  // Bullet's
  respond(/*with_springs=*/true);
  for (int i = 0; i < kMostRepeats && passes_in_contact(bodies, time_step); ++i) respond(/*with_springs=*/false);
}

}  // namespace softcd::bullet

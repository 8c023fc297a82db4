#pragma once

#include <unordered_map>

#include "bodies/world_mirror.hpp"

namespace softcd::bullet {

/// The part of the nodes' predicted motion that the pressure in their bodies adds in a step of a classic world
/// (Config::kPR and kVC). Bullet predicts nodes without their links, which then take most of this part back. So nodes
/// of a body under pressure come near others in the prediction alone. Bullet's solver would pull a node with a contact
/// there, up to the margin, because it moves less than predicted.
class PressureMotion {
 public:
  /// Reads the bodies after Bullet's prediction, which has kept their start positions and normals.
  void read(Span<const btSoftBody* const> bodies);
  /// Returns whether the contact's points are farther apart than the margins at the step's start, and would be so at
  /// its predicted end without this motion.
  bool is_cause_of(const MemberContact& found) const;

 private:
  /// For bodies under pressure: the motion of a node of mass 1 that carries a unit of area.
  std::unordered_map<const btSoftBody*, btScalar> motions_;
};

}  // namespace softcd::bullet

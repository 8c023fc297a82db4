#pragma once

#include "crossings/crossings_of_kind.hpp"

namespace softcd::bullet {

/// Changes velocities of the bodies' nodes in a classic world, so that no link gets longer in the step than twice its
/// rest length. A link that is longer when the step begins, or where Bullet's solver leaves it, may keep the greater of
/// these lengths. Returns whether a velocity has changed.
///
/// The solver moves both nodes of a link until it has its rest length, and does not know that the last pass then stops
/// one of them. The pass leaves the link stretched, and in the next step the solver moves the other node by that much,
/// at any speed. Without a limit the stretch can grow from step to step: the links of a cloth that was pulled through a
/// narrow ring became 400 times as long.
bool limit_stretch(const AnsweredBodies& answered, btScalar time_step);

}  // namespace softcd::bullet

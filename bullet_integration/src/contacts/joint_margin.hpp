#pragma once

#include <cstddef>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/core/types.hpp"

namespace softcd::bullet {

/// How far node and face come closer along the contact's normal in the step so far.
btScalar approach_of(const btSoftBody::SContact& contact);

/// The margin with which `one`, of `several` contacts of one node, moves it as far along its normal as Bullet's
/// PSolve_SContacts does that goes through all of them in turn, in so many rounds, and at least until its approach has
/// ended; at most its own margin.
///
/// Such contacts push aslant, too. Each ends its part of the approach, friction of those aslant takes back some of what
/// was pushed, and those after it, which find the approach ended, push no more. So the node goes less far than the
/// nearest of them alone, by its margin, would have it. Links and other nodes, which move it between rounds, are not
/// looked at.
btScalar joint_margin(Span<const btSoftBody::SContact> several, std::size_t one, int rounds);

}  // namespace softcd::bullet

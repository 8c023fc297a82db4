#pragma once

#include <cstddef>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/core/types.hpp"

namespace softcd::bullet {

/// Returns by how much node and face have come closer along the contact's normal in the step so far.
btScalar approach_of(const btSoftBody::SContact& contact);

/// Returns a margin for contact `one` of `several` contacts of one node at one place of a surface. With it, this
/// contact alone moves the node as far along its normal as all of them, solved in turn by Bullet's PSolve_SContacts in
/// `rounds` rounds. The contact moves the node at least until its approach has ended. The result is at most the
/// contact's own margin.
///
/// Several contacts push less far than the nearest of them alone. Each ends its part of the approach, and the friction
/// of slanting contacts takes back some of the push. Later contacts find the approach ended and push no more. Links and
/// other nodes, which move the node between rounds, are ignored.
///
/// Without this, sheets that rest on each other hop higher than with all contacts (resting_sheets_test), and balls that
/// start inside each other gain more energy.
btScalar joint_margin(Span<const btSoftBody::SContact> several, std::size_t one, int rounds);

}  // namespace softcd::bullet

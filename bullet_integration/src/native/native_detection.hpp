#pragma once

#include "native/pair_gate.hpp"
#include "softcd/core/types.hpp"

/// Bullet's own detection, for steps in which softcd's has failed. Allocates only the memory that Bullet itself needs.
namespace softcd::bullet {

/// Detects VF_SS contacts of the pairs in the broad phase's cache.
void detect_classic_contacts(Span<btSoftBody* const> bodies, const PairGate& gate, const PairRule& rule);
/// Detects VF_DD contacts of all pairs, and within bodies.
void detect_deformable_contacts(Span<btSoftBody* const> bodies, const PairGate& gate, const PairRule& rule);

}  // namespace softcd::bullet

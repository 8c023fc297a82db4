#pragma once

#include "native/pair_gate.hpp"
#include "softcd/core/types.hpp"

/// Bullet's own detection where softcd's has failed. Allocates nothing but what Bullet does.
namespace softcd::bullet {

/// VF_SS, of the pairs that the broad phase knows.
void detect_classic_contacts(Span<btSoftBody* const> bodies, const PairGate& gate, const PairRule& rule);
/// VF_DD, of all pairs and within bodies.
void detect_deformable_contacts(Span<btSoftBody* const> bodies, const PairGate& gate, const PairRule& rule);

}  // namespace softcd::bullet

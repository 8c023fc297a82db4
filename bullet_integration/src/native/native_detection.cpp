#include "native/native_detection.hpp"

#include <utility>

#include "BulletSoftBody/btSoftBodySolvers.h"
#include "native/native_trees.hpp"

namespace softcd::bullet {
namespace {

/// Bullet's handler reads the flag of the second body only.
void collide_deformable(btSoftBody& a, btSoftBody& b) {
  const bool was_on = std::exchange(b.m_softSoftCollision, true);
  a.defaultCollisionHandler(&b);
  b.m_softSoftCollision = was_on;
}

/// Gives bodies without a face tree one, so that Bullet can find vertex-face contacts. It stays, as the next step may
/// fail, too. Calls refit(body) for each body.
void build_missing_trees(Span<btSoftBody* const> bodies, void (*refit)(btSoftBody&)) {
  for (btSoftBody* body : bodies) {
    if (body->m_fdbvt.empty()) build_face_tree(*body);
    refit(*body);
  }
}

bool has_contacts_within(const btSoftBody& body) {
  return (body.m_cfg.collisions & btSoftBody::fCollision::SVSmask) == btSoftBody::fCollision::VF_DD;
}

}  // namespace

void detect_classic_contacts(Span<btSoftBody* const> bodies, const PairGate& gate, const PairRule& rule) {
  build_missing_trees(bodies, refit_classic_trees);
  const btBroadphasePair* pairs = gate.pair_cache().getOverlappingPairArrayPtr();
  for (int i = 0; i < gate.pair_cache().getNumOverlappingPairs(); ++i) {
    const auto [a, b] = soft_bodies_of(pairs[i]);
    if (a == nullptr || b == nullptr || !rule(*a, *b)) continue;
    a->getSoftBodySolver()->processCollision(a, b);
  }
}

void detect_deformable_contacts(Span<btSoftBody* const> bodies, const PairGate& /*gate*/, const PairRule& rule) {
  build_missing_trees(bodies, [](btSoftBody& body) {
    body.updateNodeTree(/*use_velocity=*/true, /*margin=*/true);
    body.updateFaceTree(/*use_velocity=*/true, /*margin=*/true);
  });
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (has_contacts_within(*bodies[i])) collide_deformable(*bodies[i], *bodies[i]);
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      if (!rule(*bodies[i], *bodies[j])) continue;
      collide_deformable(*bodies[i], *bodies[j]);
    }
  }
}

}  // namespace softcd::bullet

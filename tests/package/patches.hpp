#pragma once

#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <memory>

/// A horizontal patch within the default margins' reach of its neighbours, in a world that it leaves on destruction.
template <class World>
class Patch {
 public:
  Patch(World& world, btScalar height, int collisions)
      : world_(world),
        body_(btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), {-1, height, -1}, {1, height, -1}, {-1, height, 1},
                                             {1, height, 1}, 8, 8, 0, true)) {
    body_->m_cfg.collisions = collisions;
    world_.addSoftBody(body_.get());
  }
  ~Patch() { world_.removeSoftBody(body_.get()); }
  Patch(const Patch&) = delete;
  Patch& operator=(const Patch&) = delete;

  int count_contacts() const { return body_->m_scontacts.size() + body_->m_faceNodeContacts.size(); }

 private:
  World& world_;
  std::unique_ptr<btSoftBody> body_;
};

/// Returns main()'s result: 0 if two patches close to each other have contacts after one step.
template <class World>
int check_contacts(World& world, int collisions) {
  const Patch<World> lower(world, 0, collisions);
  const Patch<World> upper(world, btScalar(0.1), collisions);
  world.stepSimulation(btScalar(1) / 60, 1);
  return lower.count_contacts() + upper.count_contacts() > 0 ? 0 : 1;
}

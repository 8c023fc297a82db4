#pragma once

#include "worlds/attached_world.hpp"

namespace softcd::bullet {

/// An attached btSoftRigidDynamicsWorld or btSoftMultiBodyDynamicsWorld. After their solver of soft bodies, they call
/// nothing that can be set from outside. So steps end late.
class AttachedClassicWorld final : public AttachedWorld {
 public:
  AttachedClassicWorld(btDynamicsWorld& world, const SoftBodies& bodies, const Settings& settings)
      : AttachedWorld(world, bodies, kClassicWorld, settings) {}

  Span<const Limitation> limitations() const override;

 private:
  void process_step_pairs(const Processing& process_natively) override {
    process_classic_pairs(step(), process_natively);
  }
  void make_up_for_pairs() override;
  void prepare_solver() override { prepare_classic_solver(step()); }
  void end_step(btScalar time_step) override;
  bool ends_steps_late() const override { return true; }
};

}  // namespace softcd::bullet

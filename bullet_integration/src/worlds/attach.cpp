#include "softcd/bullet/attach.hpp"

#include <iterator>

#include "worlds/attached_deformable_world.hpp"

#include "softcd/bullet/deformable_world.hpp"
#include "softcd/bullet/dispatcher.hpp"
#include "softcd/bullet/soft_worlds.hpp"

namespace softcd::bullet {
namespace {

/// An attached btSoftRigidDynamicsWorld or btSoftMultiBodyDynamicsWorld. After their solver of soft bodies, they call
/// nothing that can be set from outside. So steps end late.
class AttachedClassicWorld final : public AttachedWorld {
 public:
  AttachedClassicWorld(btDynamicsWorld& world, const SoftBodies& bodies, const Settings& settings)
      : AttachedWorld(world, bodies, kClassicWorld, settings) {}

  Span<const Limitation> limitations() const override {
    static constexpr Limitation kLimitations[] = {
        kTreesLimitation,
        {Limit::ends_steps_late,
         "The part of softcd's step after Bullet's solver of soft bodies (the last pass of Detection::ccd, impulses, "
         "on_contacts) waits for finish_step() or the beginning of the next step."},
        kRigidMeshesLimitation,
    };
    return {kLimitations, std::size(kLimitations) - (sees_pairs() ? 1 : 0)};
  }

 private:
  ClassicStep step() const { return AttachedWorld::step<ClassicStep>(); }
  void process(const Processing& process_natively) override { step().process(process_natively); }
  void process_late() override { step().process_late(); }
  void prepare_solver() override { step().before_solver(); }
  void end_step(btScalar time_step) override {
    queries().mirror.resume_step(bodies());
    step().end(time_step);
  }
  bool ends_steps_late() const override { return true; }
};

bool detects_already(btDynamicsWorld& world) {
  const auto* dispatcher = dynamic_cast<const Dispatcher*>(world.getDispatcher());
  return AttachedWorld::of(world) != nullptr || dynamic_cast<SoftRigidDynamicsWorld*>(&world) != nullptr ||
         dynamic_cast<SoftMultiBodyDynamicsWorld*>(&world) != nullptr ||
         dynamic_cast<DeformableWorld*>(&world) != nullptr ||
         (dispatcher != nullptr && dispatcher->serves(*world.getBroadphase()));
}

std::unique_ptr<AttachedWorld> make_attached(btDynamicsWorld& world, const Settings& settings) {
  if (auto* soft = dynamic_cast<btSoftRigidDynamicsWorld*>(&world)) {
    return std::make_unique<AttachedClassicWorld>(world, soft->getSoftBodyArray(), settings);
  }
  if (auto* soft = dynamic_cast<btSoftMultiBodyDynamicsWorld*>(&world)) {
    return std::make_unique<AttachedClassicWorld>(world, soft->getSoftBodyArray(), settings);
  }
  if (auto* deformable = dynamic_cast<btDeformableMultiBodyDynamicsWorld*>(&world)) {
    return std::make_unique<AttachedDeformableWorld>(*deformable, settings);
  }
  throw InvalidInput(
      "softcd::bullet::attach: the world is none of Bullet's with soft bodies; make a "
      "btSoftRigidDynamicsWorld, btSoftMultiBodyDynamicsWorld or btDeformableMultiBodyDynamicsWorld");
}

}  // namespace

Attachment::Attachment(std::unique_ptr<AttachedWorld> attached) : attached_(std::move(attached)) {}

Attachment::Attachment(Attachment&&) noexcept = default;

Attachment& Attachment::operator=(Attachment&& other) noexcept {
  const Attachment old(std::move(*this));
  attached_ = std::move(other.attached_);
  return *this;
}

Attachment::~Attachment() {
  if (attached_ == nullptr) return;
  try {
    attached_->detach();
  } catch (...) {
    // The world is detached nevertheless.
  }
}

bool Attachment::is_attached() const {
  return attached_ != nullptr && attached_->is_attached();
}

void Attachment::detach() {
  attached_->detach();
}

void Attachment::finish_step() {
  attached_->finish_step();
}

Span<const Limitation> Attachment::limitations() const {
  return attached_->limitations();
}

WorldDetection& Attachment::detection() {
  return attached_->detection();
}

const WorldDetection& Attachment::detection() const {
  return attached_->detection();
}

}  // namespace softcd::bullet

softcd::bullet::Attachment softcd::bullet::attach(btDynamicsWorld& world, const Settings& settings) {
  if (detects_already(world)) {
    throw InvalidInput(
        "softcd::bullet::attach: softcd already detects in this world; use its detection(), or "
        "detach first");
  }
  return Attachment(make_attached(world, settings));
}

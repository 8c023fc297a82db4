#pragma once

#include <functional>
#include <string>
#include <utility>

#include "BulletDynamics/Dynamics/btActionInterface.h"
#include "BulletDynamics/Dynamics/btDynamicsWorld.h"

namespace softcd::test {

enum class When { before_tick, in_action, after_tick };

inline std::string name_of(When when) {
  switch (when) {
    case When::before_tick:
      return "before_tick";
    case When::in_action:
      return "in_action";
    case When::after_tick:
      return "after_tick";
  }
  return "?";
}

/// Calls a function at one point of the next step.
class Interruption : public btActionInterface {
 public:
  Interruption(btDynamicsWorld& world, When when, std::function<void()> f)
      : world_(world), when_(when), f_(std::move(f)) {
    if (when_ == When::in_action) {
      world_.addAction(this);
    } else {
      world_.setInternalTickCallback(tick, this, when_ == When::before_tick);
    }
  }
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;
  ~Interruption() override {
    if (when_ == When::in_action) {
      world_.removeAction(this);
    } else {
      world_.setInternalTickCallback(nullptr, nullptr, when_ == When::before_tick);
    }
  }

  void updateAction(btCollisionWorld* /*world*/, btScalar /*seconds*/) override { interrupt(); }
  void debugDraw(btIDebugDraw* /*drawer*/) override {}

 private:
  static void tick(btDynamicsWorld* world, btScalar /*seconds*/) {
    static_cast<Interruption*>(world->getWorldUserInfo())->interrupt();
  }
  void interrupt() {
    if (f_) std::exchange(f_, {})();
  }

  btDynamicsWorld& world_;
  When when_;
  std::function<void()> f_;
};

}  // namespace softcd::test

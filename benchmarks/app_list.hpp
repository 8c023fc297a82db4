#pragma once

#include <functional>
#include <vector>

#include "app_world.hpp"

namespace softcd::benchmarks {

/// Moves the bodies that an app moves itself. Called before each step, with the time at which the step ends and its
/// length.
using AppDrive = std::function<void(btScalar time, btScalar seconds)>;

/// A small program as a Bullet user might write it, with the settings that its author chose.
struct App {
  const char* name;
  const char* description;
  double seconds;
  btScalar lowest;  ///< a free body below this height is lost: see AppWorld::count_lost()
  /// Adds the app's bodies to an empty world. The returned function is empty where the app moves nothing.
  AppDrive (*build)(AppWorld& world);
};

const std::vector<App>& apps();

}  // namespace softcd::benchmarks

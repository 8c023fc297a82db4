#pragma once

#include <cstdint>

#include "scenes/soft_world.hpp"

namespace softcd::benchmarks {

using demo::SoftWorld;
using demo::World;

enum class BulletScene : std::uint32_t {
  two_cloths,  ///< one falls onto the other, which is held along its border
  balls,       ///< `size` balls of 1280 triangles that drop onto a floor and each other
  draped,      ///< a cloth falls over rigid balls on a floor
  crumpling,   ///< a cloth that stands in folds sinks into a heap on a floor
  stacked,     ///< two cloths that touch themselves lie flat on a floor, one on the other
};

/// Adds the scene's bodies to an empty world. `size` is the number of nodes along a side of each cloth. All cells but
/// those of `two_cloths` always have the same size, so that all sizes behave alike.
void fill(SoftWorld& world, BulletScene scene, int size);

/// Returns the number of steps after which the scene looks as its name says.
int default_warm_up(BulletScene scene, World world);

}  // namespace softcd::benchmarks

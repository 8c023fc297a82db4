#pragma once

#include <memory>
#include <vector>

#include "scenes/soft_world.hpp"

namespace softcd::demo {

/// Soft bodies that start through each other, or through themselves.
struct IntersectingBodies {
  const char* name;
  const char* description;
  /// Makes them around the origin, about a metre in size. `size` is the number of nodes along a cloth.
  std::vector<std::unique_ptr<btSoftBody>> (*make)(btSoftBodyWorldInfo&, World, int size);
};

/// Returns all kinds.
const std::vector<IntersectingBodies>& intersecting_bodies();

/// Returns the kind of that name. Throws std::invalid_argument when there is none.
const IntersectingBodies& find_intersecting_bodies(const char* name);

}  // namespace softcd::demo

#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/core/types.hpp"

namespace softcd::demo {

/// A corner of a pin's triangle.
struct PinCorner {
  Vec3f position, normal;
};

/// Returns small octahedra, three corners a triangle, at the nodes that hold a body up: those without mass, of a body
/// that has others with mass. None where all nodes have mass, or none has.
std::vector<PinCorner> pins_of(const btSoftBody& body);

}  // namespace softcd::demo

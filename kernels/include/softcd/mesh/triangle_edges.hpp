#pragma once

#include <cstdint>

namespace softcd {

/// The indices of a triangle's edges. e[i] joins v[i] and v[(i + 1) % 3]; kNoIndex where the two are one vertex.
struct TriangleEdges {
  std::uint32_t e[3];
};

}  // namespace softcd

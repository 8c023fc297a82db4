#pragma once

#include <cstdint>

#include "softcd/stages/bounding_volumes.hpp"

namespace softcd::cpu {

/// Calls f(i) for begin <= i < end.
template <class F>
void for_range(const F& f, std::uint32_t begin, std::uint32_t end) {
  for (std::uint32_t i = begin; i < end; ++i) f(i);
}

/// Does the same for triangles. Bounds several at once, in whatever registers the processor has.
void for_range(const BoundTriangle& bound, std::uint32_t begin, std::uint32_t end);

}  // namespace softcd::cpu

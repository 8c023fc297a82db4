#pragma once

#include <cstddef>

#include "LinearMath/btAlignedObjectArray.h"
#include "softcd/core/span.hpp"

namespace softcd::bullet {

/// Returns a view of one of Bullet's arrays.
template <class T>
Span<T> span_of(btAlignedObjectArray<T>& array) {
  if (array.size() == 0) return {};
  return {&array[0], static_cast<std::size_t>(array.size())};
}
template <class T>
Span<const T> span_of(const btAlignedObjectArray<T>& array) {
  if (array.size() == 0) return {};
  return {&array[0], static_cast<std::size_t>(array.size())};
}

}  // namespace softcd::bullet

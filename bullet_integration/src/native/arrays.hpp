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

/// Calls visit(entry) while the i-th entry is the array's first and only one.
template <class Entry, class Visit>
void with_single_entry(btAlignedObjectArray<Entry>& array, int i, Visit visit) {
  const int count = array.size();
  Entry* const entries = &array[0];
  if (i > 0) btSwap(entries[0], entries[i]);
  array.resizeNoInitialize(1);
  visit(entries[0]);
  array.resizeNoInitialize(count);
  if (i > 0) btSwap(entries[0], entries[i]);
}

}  // namespace softcd::bullet

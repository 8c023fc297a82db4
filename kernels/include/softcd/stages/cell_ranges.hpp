#pragma once

#include <cstdint>

#include "softcd/grid/control_bits.hpp"
#include "softcd/stages/cell_assignment.hpp"

namespace softcd {

/// First position whose key is not less than `key`, for a key of the block that ends at `from`: gallops backwards, so
/// it costs the logarithm of the distance.
SOFTCD_HD inline std::uint32_t gallop_back(const std::uint32_t* keys, std::uint32_t from, std::uint32_t key) {
  std::uint32_t step = 1;
  while (step <= from && !(keys[from - step] < key)) step *= 2;
  const std::uint32_t begin = step <= from ? from - step : 0;
  return static_cast<std::uint32_t>(lower_bound_index(keys, begin, from - step / 2, key));
}

/// For each sorted entry: where its cell begins, and how many entries before it in the cell it may have to be tested
/// with.
template <class Control>
struct CountPartners {
  const std::uint32_t* keys;
  std::uint32_t* partner_begin;
  std::uint32_t* partner_count;

  template <class Cells>
  SOFTCD_HD void operator()(std::uint32_t j, Cells& cells) const {
    const std::uint32_t key = keys[j];
    const std::uint32_t begin = gallop_back(keys, j, key & ~7U);
    if (begin == j) cells.push(j);
    const std::uint32_t last_class = 7U - Control::lowest_partner_k(key_k(key));
    std::uint32_t end = j;
    if (last_class < (key & 7U)) {
      end = static_cast<std::uint32_t>(lower_bound_index<std::uint32_t>(keys, begin, j, (key & ~7U) + last_class + 1U));
    }
    partner_begin[j] = begin;
    partner_count[j] = end - begin;
  }
};

}  // namespace softcd

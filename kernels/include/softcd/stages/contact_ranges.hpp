#pragma once

#include <cstdint>

#include "softcd/core/contact.hpp"
#include "softcd/core/count.hpp"
#include "softcd/core/host_device.hpp"

namespace softcd {

/// Finds where the contacts of one kind and one body begin, among all contacts in order. Called for 2 * body_ids + 1
/// ranges; the last one is the end of all. See DeviceContacts::body_begin.
struct FindBodyRange {
  const Contact* contacts;
  Count count;
  std::uint64_t body_ids;
  std::uint64_t* body_begin;

  SOFTCD_HD void operator()(std::uint32_t range) const {
    std::uint64_t begin = 0;
    std::uint64_t end = count.get();
    while (begin < end) {
      const std::uint64_t middle = begin + (end - begin) / 2;
      const Contact& contact = contacts[middle];
      if (static_cast<std::uint64_t>(contact.kind) * body_ids + contact.body_a.value < range) {
        begin = middle + 1;
      } else {
        end = middle;
      }
    }
    body_begin[range] = begin;
  }
};

}  // namespace softcd

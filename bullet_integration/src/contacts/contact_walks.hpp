#pragma once

#include <algorithm>

#include "bodies/world_mirror.hpp"
#include "softcd/core/parallel.hpp"

namespace softcd::bullet {

/// Returns the contacts of edges, which a query returns after those of vertices with faces.
inline Span<const Contact> edge_contacts_in(Span<const Contact> contacts) {
  const auto* const first = std::partition_point(
      contacts.begin(), contacts.end(), [](const Contact& c) { return c.kind == ContactKind::vertex_triangle; });
  return {first, static_cast<std::size_t>(contacts.end() - first)};
}

/// Calls visit(index, MemberContact) for each contact, from several threads.
template <class Visit>
void for_each_contact_in_parallel(const WorldMirror& mirror, Span<const Contact> contacts, const Visit& visit) {
  constexpr std::size_t kContactsAtOnce = 1024;
  parallel::for_ranges(contacts.size(), kContactsAtOnce, [&](std::size_t begin, std::size_t end) {
    std::size_t i = begin;
    mirror.for_each_contact({contacts.begin() + begin, end - begin},
                            [&](const MemberContact& found) { visit(i++, found); });
  });
}

}  // namespace softcd::bullet

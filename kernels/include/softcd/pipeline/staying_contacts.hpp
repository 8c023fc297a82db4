#pragma once

#include <cstddef>
#include <cstdint>

#include "softcd/pipeline/lists.hpp"
#include "softcd/stages/contact_ranges.hpp"

namespace softcd {

/// Ends a detection whose contacts stay in the backend's memory. Writes their number, and whether they are complete:
/// what the host would check before it returns contacts.
template <std::size_t kLists>
struct ConcludeContacts {
  Counters* counters;
  ListBound lists[kLists];
  bool needs_short_runs;
  const std::uint64_t* edge_edge_begin;  ///< among the contacts
  ContactCounts* out;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    if (!team.is_leader()) return;
    counters->vt_contacts = *edge_edge_begin;
    bool is_complete = counters->all > 0 && counters->long_bins == 0 && (!needs_short_runs || counters->long_runs == 0);
    for (const ListBound& list : lists) is_complete &= list.holds_all();
    *out = {counters->contacts, is_complete ? 1U : 0U, 0U};
  }
};

}  // namespace softcd

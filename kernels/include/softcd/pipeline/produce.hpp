#pragma once

#include <array>
#include <tuple>

#include "softcd/pipeline/workspace.hpp"

namespace softcd {

/// Runs `stage`, which appends to `lists`. A backend that knows counts at once grows the lists that overflowed and runs
/// the stage again; one that does not leaves that to the detector, which looks at all counters at the end (see
/// grow_lists).
template <class Backend, class Work, class... Lists>
void produce(Backend& backend, Counters* counters, const Work& stage, Lists&... lists) {
  if constexpr (Backend::kKnowsCounts) {
    const std::array<std::uint64_t, sizeof...(Lists)> kept = {counters->*lists.counter()...};
    stage();
    if (((counters->*lists.counter() <= lists.capacity()) && ...)) return;
    std::size_t i = 0;
    (lists.reserve(backend, counters->*lists.counter(), kept[i++]), ...);
    i = 0;
    ((counters->*lists.counter() = kept[i++]), ...);
    backend.count_rerun();
    stage();
  } else {
    stage();
  }
}

/// After a detection: sizes every list for one like it.
template <class... Lists>
void fit_lists(const Counters& counters, Lists&... lists) {
  (lists.fit(counters.*lists.counter()), ...);
}

/// After a detection: grows every list that was asked for more than it holds. True when one did, so that the detection
/// has to be repeated.
template <class Backend, class... Lists>
bool grow_lists(Backend& backend, const Counters& counters, Lists&... lists) {
  const bool overflowed = ((counters.*lists.counter() > lists.capacity()) || ...);
  (lists.reserve(backend, counters.*lists.counter(), 0), ...);
  return overflowed;
}

}  // namespace softcd

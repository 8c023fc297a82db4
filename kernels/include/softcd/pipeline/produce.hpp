#pragma once

#include <array>
#include <tuple>

#include "softcd/pipeline/lists.hpp"

namespace softcd {

/// Runs `stage`, which appends to `lists`. A backend that knows counts at once grows the lists that overflowed and runs
/// the stage again. Others leave that to the detector, which checks all counters at the end (see grow_lists).
template <class Backend, class Work, class... Lists>
void produce(Backend& backend, Counters* counters, const Work& stage, Lists&... lists) {
  if constexpr (Backend::kKnowsCounts) {
    const std::array<std::uint64_t, sizeof...(Lists)> kept = {lists.counted(*counters)...};
    stage();
    if (((lists.counted(*counters) <= lists.capacity()) && ...)) return;
    std::size_t i = 0;
    (lists.reserve(backend, lists.counted(*counters), kept[i++]), ...);
    i = 0;
    ((lists.counted(*counters) = kept[i++]), ...);
    backend.count_rerun();
    stage();
  } else {
    stage();
  }
}

/// Sizes every list for another detection like the last one.
template <class... Lists>
void fit_lists(const Counters& counters, Lists&... lists) {
  (lists.fit(lists.counted(counters)), ...);
}

/// Grows every list that was asked for more than it holds. Returns true if there was one, so that the detection has to
/// be repeated.
template <class Backend, class... Lists>
bool grow_lists(Backend& backend, const Counters& counters, Lists&... lists) {
  const bool overflowed = ((lists.counted(counters) > lists.capacity()) || ...);
  (lists.reserve(backend, lists.counted(counters), 0), ...);
  return overflowed;
}

}  // namespace softcd

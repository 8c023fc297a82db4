#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <tuple>

#include "output.hpp"
#include "softcd/core/count.hpp"
#include "softcd/core/parallel.hpp"

namespace softcd::cpu {

/// Calls the functor for every unit of an item's work.
template <class F>
struct AllUnits {
  const F& f;

  template <class... Outputs>
  void run(std::uint32_t item, std::uint32_t begin, std::uint32_t end, Outputs&... outputs) const {
    for (std::uint32_t k = begin; k < end; ++k) f(item, k, outputs...);
  }
  template <class... Outputs>
  void finish(Outputs&... /*outputs*/) const {}
};

constexpr std::uint32_t kUnitsAtOnce = 64;

/// Tests several units of an item at once, for functors whose filter allows that. Bit k of may_pass(f, item, begin,
/// count), where count <= kUnitsAtOnce, is clear only if f.filter(item, begin + k, candidate) is false.
template <class F>
struct UnitLanes;

template <class F>
concept HasUnitLanes = requires(const F& f, const typename F::Item& item) {
  { UnitLanes<F>::may_pass(f, item, 0U, 0U) } -> std::same_as<std::uint64_t>;
};

/// Calls offer(k) for the units from `begin` to `end` of an item, except those that are known not to pass the filter.
template <class F, class Offer>
void for_each_unit_that_may_pass(const F& f, const typename F::Item& item, std::uint32_t begin, std::uint32_t end,
                                 const Offer& offer) {
  if constexpr (HasUnitLanes<F>) {
    for (; begin < end; begin += kUnitsAtOnce) {
      std::uint64_t left = UnitLanes<F>::may_pass(f, item, begin, std::min(end - begin, kUnitsAtOnce));
      for (; left != 0; left &= left - 1) offer(begin + static_cast<std::uint32_t>(std::countr_zero(left)));
    }
  } else {
    for (std::uint32_t k = begin; k < end; ++k) offer(k);
  }
}

/// Gathers units of work that pass f's filter before they are tested. Whether one passes is hard to predict, and here
/// decides about no jump.
template <class F>
class Survivors {
 public:
  explicit Survivors(const F& f) : f_(f) {}

  template <class... Outputs>
  void offer(const typename F::Item& item, std::uint32_t unit, Outputs&... outputs) {
    // The next place depends on the last unit's outcome, which the filter must not wait for.
    typename F::Candidate candidate{};
    const bool passes = f_.filter(item, unit, candidate);
    candidates_[size_] = candidate;
    size_ += passes ? 1U : 0U;
    if (size_ == kRoom) test(outputs...);
  }
  template <class... Outputs>
  void test(Outputs&... outputs) {
    for (std::uint32_t i = 0; i < size_; ++i) f_.test(candidates_[i], outputs...);
    size_ = 0;
  }

 private:
  static constexpr std::uint32_t kRoom = 128;

  const F& f_;
  std::uint32_t size_ = 0;
  std::array<typename F::Candidate, kRoom> candidates_;
};

constexpr std::uint32_t kCandidatesAtOnce = 64;

/// Tests several candidates at once, for functors whose filter and test are one test of a candidate. f.list(item, unit,
/// candidate) makes a candidate, and f.append(candidate, outputs...) writes it. Bit i of keep(f, candidates, count),
/// where count <= kCandidatesAtOnce, is set if candidate i passes both.
template <class F>
struct CandidateLanes;

template <class F>
concept HasCandidateLanes = requires(const F& f, const typename F::Candidate* candidates) {
  { CandidateLanes<F>::keep(f, candidates, 0U) } -> std::same_as<std::uint64_t>;
};

/// Replaces Survivors if several candidates can be tested at once: gathers all of them.
template <class F>
class Candidates {
 public:
  explicit Candidates(const F& f) : f_(f) {}

  template <class... Outputs>
  void offer(const typename F::Item& item, std::uint32_t unit, Outputs&... outputs) {
    size_ += f_.list(item, unit, candidates_[size_]) ? 1U : 0U;
    if (size_ == kCandidatesAtOnce) test(outputs...);
  }
  template <class... Outputs>
  void test(Outputs&... outputs) {
    if (size_ == 0) return;
    std::uint64_t left = CandidateLanes<F>::keep(f_, candidates_.data(), size_);
    for (; left != 0; left &= left - 1) {
      f_.append(candidates_[static_cast<std::size_t>(std::countr_zero(left))], outputs...);
    }
    size_ = 0;
  }

 private:
  const F& f_;
  std::uint32_t size_ = 0;
  std::array<typename F::Candidate, kCandidatesAtOnce> candidates_;
};

/// Functors whose UnitLanes leave nothing to the filter. f.list(item, unit, candidate) makes a candidate that
/// f.test_meeting(candidate, outputs...) tests.
template <class F>
concept HasDecidingLanes = HasUnitLanes<F> && UnitLanes<F>::kDecides;

/// Replaces Survivors if lanes have decided: there is nothing to gather.
template <class F>
class DecidedUnits {
 public:
  explicit DecidedUnits(const F& f) : f_(f) {}

  template <class... Outputs>
  void offer(const typename F::Item& item, std::uint32_t unit, Outputs&... outputs) const {
    typename F::Candidate candidate;  // NOLINT(cppcoreguidelines-pro-type-member-init): list() sets it
    f_.list(item, unit, candidate);
    f_.test_meeting(candidate, outputs...);
  }
  template <class... Outputs>
  void test(Outputs&... /*outputs*/) const {}

 private:
  const F& f_;
};

template <class F>
struct Gathering {
  using Type = Survivors<F>;
};
template <HasCandidateLanes F>
struct Gathering<F> {
  using Type = Candidates<F>;
};
template <HasDecidingLanes F>
struct Gathering<F> {
  using Type = DecidedUnits<F>;
};
template <class F>
using GatheredUnits = typename Gathering<F>::Type;

/// Runs the units of an item's work that pass the filter.
template <class F>
class FilteredUnits {
 public:
  explicit FilteredUnits(const F& f) : f_(f), survivors_(f) {}

  template <class... Outputs>
  void run(std::uint32_t i, std::uint32_t begin, std::uint32_t end, Outputs&... outputs) {
    const typename F::Item item = f_.load_item(i);
    for_each_unit_that_may_pass(f_, item, begin, end, [&](std::uint32_t k) { survivors_.offer(item, k, outputs...); });
  }
  template <class... Outputs>
  void finish(Outputs&... outputs) {
    survivors_.test(outputs...);
  }

 private:
  const F& f_;
  Survivors<F> survivors_;
};

/// Calls Units::run(item, begin, end, outputs...) in parallel, for shares of items' work that add up to all of it. Each
/// task has its own Units{f}, and at least `grain` units of work if there are several tasks.
template <class Units, class F, class... Targets>
void distribute(Count items, const std::uint64_t* offsets, const std::uint64_t* total, Share share, std::uint64_t grain,
                const F& f, Appender<Targets>... lists) {
  const std::uint64_t item_count = items.get();
  const std::uint64_t work = item_count == 0 ? 0 : *total;
  const std::uint64_t first = share.begin(work);
  parallel::for_ranges(share.end(work) - first, grain, [&](std::uint64_t range_begin, std::uint64_t range_end) {
    const std::uint64_t begin = first + range_begin;
    const std::uint64_t end = first + range_end;
    std::tuple<Output<Targets>...> outputs(lists...);
    const std::uint64_t* const next = std::upper_bound(offsets, offsets + item_count, begin);
    auto item = static_cast<std::uint64_t>(next - offsets) - 1;
    Units units{f};
    std::apply(
        [&](auto&... output) {
          for (std::uint64_t at = begin; at < end; ++item) {
            const std::uint64_t item_end = std::min(end, item + 1 < item_count ? offsets[item + 1] : work);
            if (item_end <= at) continue;
            units.run(static_cast<std::uint32_t>(item), static_cast<std::uint32_t>(at - offsets[item]),
                      static_cast<std::uint32_t>(item_end - offsets[item]), output...);
            at = item_end;
          }
          units.finish(output...);
        },
        outputs);
  });
}

}  // namespace softcd::cpu

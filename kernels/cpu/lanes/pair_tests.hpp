#pragma once

#include "../work_units.hpp"
#include "partners.hpp"
#include "softcd/stages/pair_tests.hpp"

namespace softcd::cpu {

template <bool kSwept>
struct UnitLanes<TestPair<ExactControl, kSwept>> {
  using F = TestPair<ExactControl, kSwept>;
  static constexpr bool kDecides = false;

  static std::uint64_t may_pass(const F& /*f*/, const typename F::Item& item, std::uint32_t begin,
                                std::uint32_t count) {
    static_assert(kUnitsAtOnce <= kMostPartners);
    return partners_to_test<kSwept>(item.boxed, item.partners + begin, count);
  }
};

}  // namespace softcd::cpu

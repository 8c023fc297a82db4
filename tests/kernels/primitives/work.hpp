#pragma once

#include "primitives.hpp"

// Primitives that divide units of work evenly, however unevenly they belong to items.
namespace softcd::test {

struct WorkOfItems {
  struct Item {
    std::uint32_t index;
  };
  struct Candidate {
    std::uint64_t key;
  };

  template <class Units>
  SOFTCD_HD void operator()(std::uint32_t item, std::uint32_t unit, Units& units) const {
    units.push(unit_key(item, unit));
  }
  SOFTCD_HD Item load_item(std::uint32_t i) const { return {i}; }
  SOFTCD_HD bool filter(const Item& item, std::uint32_t unit, Candidate& candidate) const {
    candidate = {unit_key(item.index, unit)};
    return passes(candidate.key);
  }
  template <class Units, class Odds>
  SOFTCD_HD void test(const Candidate& candidate, Units& units, Odds& odds) const {
    units.push(candidate.key);
    if (candidate.key % 2U == 1U) odds.push(candidate.key);
  }
};

inline bool passes_oddly(std::uint64_t key) {
  return passes(key) && key % 2U == 1U;
}

template <class Machine>
class WorkPrimitives : public Primitives<Machine> {};
TYPED_TEST_SUITE_P(WorkPrimitives);

TYPED_TEST_P(WorkPrimitives, for_each_work_calls_with_every_unit) {
  for (const std::uint32_t size : kSizes) {
    SCOPED_TRACE(size);
    const UnitCounts all(size);
    const auto value = this->one_count(size);
    const auto begins = this->uploaded(all.begins());
    const auto total = this->one_count(all.total());
    const auto make_list = [&](std::uint64_t capacity) { return this->template make_list<std::uint64_t>(capacity); };
    expect_units_in_any_room(size, make_list, all_units, [&](auto& units) {
      this->backend().for_each_work("for_each_work", Count{value.data(), size}, begins.data(), total.data(),
                                    WorkOfItems{}, units.appender());
    });
  }
}

TYPED_TEST_P(WorkPrimitives, for_each_work_filtered_tests_what_passes) {
  for (const std::uint32_t size : kSizes) {
    SCOPED_TRACE(size);
    const UnitCounts all(size);
    const auto value = this->one_count(size);
    const auto begins = this->uploaded(all.begins());
    const auto total = this->one_count(all.total());
    const auto make_list = [&](std::uint64_t capacity) { return this->template make_list<std::uint64_t>(capacity); };
    expect_units_in_any_room(size, make_list, passes, [&](auto& units) {
      auto odds = make_list(all.total());
      this->backend().for_each_work_filtered("for_each_work_filtered", Count{value.data(), size}, begins.data(),
                                             total.data(), Share{0, 1}, WorkOfItems{}, units.appender(),
                                             odds.appender());
      UnitCounts odd_units(size);
      odd_units.add(odds.stored());
      odd_units.expect_only(passes_oddly);
    });
  }
}

TYPED_TEST_P(WorkPrimitives, shares_of_for_each_work_filtered_add_up) {
  for (const std::uint32_t size : kSizes) {
    SCOPED_TRACE(size);
    const UnitCounts all(size);
    const auto value = this->one_count(size);
    const auto begins = this->uploaded(all.begins());
    const auto total = this->one_count(all.total());
    UnitCounts units(size);
    for (const std::uint32_t share : {0U, 1U, 2U}) {
      auto list = this->template make_list<std::uint64_t>(all.total());
      auto odds = this->template make_list<std::uint64_t>(all.total());
      this->backend().for_each_work_filtered("for_each_work_filtered", Count{value.data(), size}, begins.data(),
                                             total.data(), Share{share, 3}, WorkOfItems{}, list.appender(),
                                             odds.appender());
      const std::uint64_t most = all.total() / 3 + 1;
      EXPECT_LE(list.count(), most);
      units.add(list.stored());
    }
    units.expect_only(passes);
  }
}

REGISTER_TYPED_TEST_SUITE_P(WorkPrimitives, for_each_work_calls_with_every_unit,
                            for_each_work_filtered_tests_what_passes, shares_of_for_each_work_filtered_add_up);

}  // namespace softcd::test

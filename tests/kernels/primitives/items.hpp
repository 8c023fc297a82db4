#pragma once

#include "primitives.hpp"

// Primitives that call a functor for every item, or for every part of every item.
namespace softcd::test {

struct WriteSquare {
  std::uint64_t* squares;
  SOFTCD_HD void operator()(std::uint32_t i) const { squares[i] = static_cast<std::uint64_t>(i) * i; }
};

struct PushUnits {
  template <class Units, class Multiples>
  SOFTCD_HD void operator()(std::uint32_t i, Units& units, Multiples& multiples) const {
    for (std::uint32_t unit = 0; unit < unit_count(i); ++unit) units.push(unit_key(i, unit));
    if (i % 3U == 0U) multiples.push(i);
  }
};

/// Puts units at places that are reserved together.
struct PutUnits {
  template <class Units>
  SOFTCD_HD void operator()(std::uint32_t i, Units& units) const {
    auto room = units.allocate(unit_count(i));
    for (std::uint32_t unit = 0; unit < unit_count(i); ++unit) room.put(unit_key(i, unit));
  }
};

struct PartsOfItems {
  struct Item {
    std::uint32_t index;
    SOFTCD_HD std::uint32_t part_count() const { return unit_count(index); }
  };
  struct Candidate {
    std::uint64_t key;
  };

  SOFTCD_HD Item load_item(std::uint32_t i) const { return {i}; }

  template <class Units>
  SOFTCD_HD void operator()(const Item& item, std::uint32_t part, Units& units) const {
    units.push(unit_key(item.index, part));
  }
  SOFTCD_HD bool filter(const Item& item, std::uint32_t part, Candidate& candidate) const {
    candidate = {unit_key(item.index, part)};
    return passes(candidate.key);
  }
  template <class Units>
  SOFTCD_HD void test(const Candidate& candidate, Units& units) const {
    units.push(candidate.key);
  }
};

/// Searches of up to hundreds of steps, of which a third are done at once.
struct CountSteps {
  struct Search {
    std::uint32_t item;
    std::uint32_t steps;
  };

  static SOFTCD_HD std::uint32_t steps_of(std::uint32_t i) { return i % 67U == 0U ? 200U : i % 3U; }

  template <class Units>
  SOFTCD_HD bool begin(std::uint32_t i, Search& search, Units& units) const {
    search = {i, 0U};
    if (steps_of(i) == 0U) units.push(unit_key(i, 0U));
    return steps_of(i) == 0U;
  }
  SOFTCD_HD bool advance(Search& search) const { return ++search.steps == steps_of(search.item); }
  template <class Units>
  SOFTCD_HD void finish(const Search& search, Units& units) const {
    if (search.item % 5U != 0U) units.push(unit_key(search.item, search.steps));
  }
};

struct WriteSum {
  const std::uint64_t* from;
  std::uint64_t* to;
  std::uint64_t add;

  SOFTCD_HD void operator()(std::uint32_t i) const { to[i] = from[i] + add; }
};

template <class Machine>
class ItemPrimitives : public Primitives<Machine> {};
TYPED_TEST_SUITE_P(ItemPrimitives);

TYPED_TEST_P(ItemPrimitives, for_each_calls_with_every_item_that_exists) {
  for (const std::uint32_t size : kSizes) {
    // Counts below, at and above the capacity.
    for (const auto& [count, capacity] : {std::pair{size, size + 5U}, {size, size}, {size + 9U, size}}) {
      auto squares = this->uploaded(std::vector<std::uint64_t>(size + 5U, 7U));
      const auto value = this->one_count(count);
      this->backend().for_each("for_each", Count{value.data(), capacity}, WriteSquare{squares.data()});
      std::vector<std::uint64_t> expected(size + 5U, 7U);
      for (std::uint64_t i = 0; i < size; ++i) expected[i] = i * i;
      EXPECT_TRUE(TypeParam::copy_out(squares.data(), size + 5U) == expected) << count << " of " << capacity;
    }
  }
}

TYPED_TEST_P(ItemPrimitives, for_each_append_appends_and_counts_what_does_not_fit) {
  for (const std::uint32_t size : kSizes) {
    SCOPED_TRACE(size);
    const auto value = this->one_count(size);
    const auto make_list = [&](std::uint64_t capacity) { return this->template make_list<std::uint64_t>(capacity); };
    expect_units_in_any_room(size, make_list, all_units, [&](auto& units) {
      auto multiples = this->template make_list<std::uint32_t>(size);
      this->backend().for_each_append("for_each_append", Count{value.data(), size}, PushUnits{}, units.appender(),
                                      multiples.appender());
      std::vector<std::uint32_t> found = multiples.stored();
      std::sort(found.begin(), found.end());
      ASSERT_EQ(found.size(), (size + 2U) / 3U);
      for (std::uint32_t i = 0; i < found.size(); ++i) ASSERT_EQ(found[i], 3U * i);
    });
  }
}

TYPED_TEST_P(ItemPrimitives, for_each_append_gives_room_for_several) {
  for (const std::uint32_t size : kSizes) {
    SCOPED_TRACE(size);
    const auto value = this->one_count(size);
    const auto make_list = [&](std::uint64_t capacity) { return this->template make_list<std::uint64_t>(capacity); };
    expect_units_in_any_room(size, make_list, all_units, [&](auto& units) {
      this->backend().for_each_append("for_each_append", Count{value.data(), size}, PutUnits{}, units.appender());
    });
  }
}

TYPED_TEST_P(ItemPrimitives, for_each_append_goes_on_where_a_list_ends) {
  const auto value = this->one_count(33);
  auto units = this->template make_list<std::uint64_t>(2 * UnitCounts(33).total());
  for (int run = 0; run < 2; ++run) {
    this->backend().for_each_append("for_each_append", Count{value.data(), 33}, PutUnits{}, units.appender());
  }
  const std::vector<std::uint64_t> stored = units.stored();
  const auto half = static_cast<std::ptrdiff_t>(stored.size() / 2);
  for (const bool is_second : {false, true}) {
    UnitCounts counts(33);
    counts.add({stored.begin() + (is_second ? half : 0), stored.begin() + (is_second ? 2 * half : half)});
    counts.expect_only(all_units);
  }
}

TYPED_TEST_P(ItemPrimitives, for_each_search_goes_to_the_end_of_each) {
  for (const std::uint32_t size : kSizes) {
    std::vector<std::uint64_t> expected;
    for (std::uint32_t i = 0; i < size; ++i) {
      const std::uint32_t steps = CountSteps::steps_of(i);
      if (steps == 0U || i % 5U != 0U) expected.push_back(unit_key(i, steps));
    }
    const auto value = this->one_count(size);
    auto units = this->template make_list<std::uint64_t>(size);
    this->backend().for_each_search("for_each_search", Count{value.data(), size}, CountSteps{}, units.appender());
    std::vector<std::uint64_t> found = units.stored();
    std::sort(found.begin(), found.end());
    EXPECT_TRUE(found == expected) << size;
  }
}

TYPED_TEST_P(ItemPrimitives, for_each_part_calls_with_every_part) {
  for (const std::uint32_t size : kSizes) {
    SCOPED_TRACE(size);
    const auto value = this->one_count(size);
    const auto make_list = [&](std::uint64_t capacity) { return this->template make_list<std::uint64_t>(capacity); };
    expect_units_in_any_room(size, make_list, all_units, [&](auto& units) {
      this->backend().for_each_part("for_each_part", Count{value.data(), size}, PartsOfItems{}, units.appender());
    });
  }
}

TYPED_TEST_P(ItemPrimitives, for_each_part_filtered_tests_what_passes) {
  for (const std::uint32_t size : kSizes) {
    SCOPED_TRACE(size);
    const auto value = this->one_count(size);
    const auto make_list = [&](std::uint64_t capacity) { return this->template make_list<std::uint64_t>(capacity); };
    expect_units_in_any_room(size, make_list, passes, [&](auto& units) {
      this->backend().for_each_part_filtered("for_each_part_filtered", Count{value.data(), size}, PartsOfItems{},
                                             units.appender());
    });
  }
}

TYPED_TEST_P(ItemPrimitives, concurrently_does_both_between_what_comes_before_and_after) {
  constexpr std::uint32_t kSize = 4096;
  const auto value = this->one_count(kSize);
  const Count count{value.data(), kSize};
  auto before = this->uploaded(std::vector<std::uint64_t>(kSize, 7U));
  auto first = this->uploaded(std::vector<std::uint64_t>(kSize, 7U));
  auto second = this->uploaded(std::vector<std::uint64_t>(kSize, 7U));
  auto after = this->uploaded(std::vector<std::uint64_t>(kSize, 7U));
  for (int round = 0; round < 20; ++round) {
    const auto add = static_cast<std::uint64_t>(round);
    this->backend().for_each("before", count, WriteSum{before.data(), before.data(), add});
    this->backend().concurrently(
        [&] {
          this->backend().for_each("first", count, WriteSum{before.data(), first.data(), 100U});
        },
        [&] {
          this->backend().for_each("second", count, WriteSum{before.data(), second.data(), 1000U});
        });
    this->backend().for_each("after", count, WriteSum{second.data(), after.data(), 10000U});
  }
  constexpr std::uint64_t kSum = 7U + 190U;
  const auto all = [](std::uint64_t each) { return std::vector<std::uint64_t>(kSize, each); };
  EXPECT_TRUE(TypeParam::copy_out(first.data(), kSize) == all(kSum + 100U));
  EXPECT_TRUE(TypeParam::copy_out(second.data(), kSize) == all(kSum + 1000U));
  EXPECT_TRUE(TypeParam::copy_out(after.data(), kSize) == all(kSum + 11000U));
}

REGISTER_TYPED_TEST_SUITE_P(ItemPrimitives, for_each_calls_with_every_item_that_exists,
                            for_each_append_appends_and_counts_what_does_not_fit,
                            for_each_append_gives_room_for_several, for_each_append_goes_on_where_a_list_ends,
                            for_each_search_goes_to_the_end_of_each, for_each_part_calls_with_every_part,
                            for_each_part_filtered_tests_what_passes,
                            concurrently_does_both_between_what_comes_before_and_after);

}  // namespace softcd::test

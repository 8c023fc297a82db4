#pragma once

#include <cstring>

#include "primitives.hpp"
#include "softcd/core/contact.hpp"
#include "softcd/pipeline/workspace.hpp"

// Primitives for memory, single calls, and results for the host.
namespace softcd::test {

struct SumAndSearch {
  const std::uint32_t* values;
  int count;
  std::uint64_t threshold;
  bool skips_zeros;
  std::uint64_t* answers;

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    const std::uint32_t* const v = values;
    const auto value_at = [v](int i) { return static_cast<std::uint64_t>(v[i]); };
    if (skips_zeros) team.skip_zeros(count, [v](int i) { return v[i] != 0; });
    const std::uint64_t sum = team.sum(count, value_at);
    const int first = team.first_exceeding(count, threshold, value_at);
    if (!team.is_leader()) return;
    answers[0] = sum;
    answers[1] = static_cast<std::uint64_t>(first);
    ++answers[2];
  }
};

struct MoveLater {
  Contact* contacts;
  SOFTCD_HD void operator()(std::uint32_t i) const { contacts[i].time_of_impact += 1.0F; }
};

template <class Machine>
class MemoryPrimitives : public Primitives<Machine> {};
TYPED_TEST_SUITE_P(MemoryPrimitives);

TYPED_TEST_P(MemoryPrimitives, buffers_keep_what_they_are_told_to_when_they_grow) {
  for (const std::uint32_t size : kSizes) {
    std::vector<std::uint32_t> values(size);
    for (std::uint32_t i = 0; i < size; ++i) values[i] = hashed(i);
    auto buffer = this->uploaded(values);
    buffer.reserve(this->backend(), 2ULL * size + 10U, size);
    EXPECT_GE(buffer.capacity(), 2ULL * size + 10U);
    EXPECT_TRUE(TypeParam::copy_out(buffer.data(), size) == values) << size;
  }
}

TYPED_TEST_P(MemoryPrimitives, teams_give_every_member_the_same_answers) {
  for (const std::uint32_t size : {1U, 31U, 32U, 33U, 255U, 256U, 257U, 4096U}) {
    for (const std::uint32_t zeros : {0U, size / 3U, size}) {  // before the other values, and behind them
      std::vector<std::uint32_t> values(size);
      std::uint64_t sum = 0;
      for (std::uint32_t i = zeros; i < size - size / 5U; ++i) sum += values[i] = hashed(i) % 1000U;
      const auto on_backend = this->uploaded(values);
      for (const std::uint64_t threshold : {std::uint64_t{0}, sum / 2, sum}) {
        std::uint64_t up_to = 0;
        std::uint64_t first = 0;
        while (first + 1 < size && (up_to += values[first]) <= threshold) ++first;
        for (const bool skips_zeros : {false, true}) {
          auto answers = this->uploaded(std::vector<std::uint64_t>(3, 0));
          this->backend().run_once("run_once", SumAndSearch{on_backend.data(), static_cast<int>(size), threshold,
                                                            skips_zeros, answers.data()});
          EXPECT_EQ(TypeParam::copy_out(answers.data(), 3), (std::vector<std::uint64_t>{sum, first, 1}))
              << size << " values, " << zeros << " zeros";
        }
      }
    }
  }
}

// Twice unchanged, then, if a backend records repeated work, replayed.
TYPED_TEST_P(MemoryPrimitives, what_is_launched_comes_back_to_the_host) {
  for (const std::uint32_t size : kSizes) {
    std::vector<Contact> expected(size);
    for (std::uint32_t i = 0; i < size; ++i) expected[i].feature_a = hashed(i);
    auto contacts = this->uploaded(expected);
    Counters counts{};
    counts.contacts = size;
    counts.chunk.pairs = 77;
    auto counters = this->uploaded(std::vector<Counters>{counts});
    const Count count{&counters.data()->contacts, contacts.capacity()};
    Signature signature{};
    signature.chunks = size;
    typename TypeParam::Backend::Session session;
    for (int run = 0; run < 4; ++run) {
      this->backend().begin_detection(session);
      this->backend().launch(signature, [&] {
        this->backend().for_each("for_each", count, MoveLater{contacts.data()});
        this->backend().download(counters, contacts, count, true);
      });
      for (Contact& contact : expected) contact.time_of_impact += 1.0F;
      EXPECT_EQ(this->backend().read(counters).contacts, size);
      const Counters found = this->backend().finish();
      EXPECT_EQ(found.contacts, size);
      EXPECT_EQ(found.chunk.pairs, 77U);
      const Span<const Contact> downloaded = this->backend().contacts(size);
      ASSERT_EQ(downloaded.size(), size);
      EXPECT_TRUE(size == 0 || std::memcmp(downloaded.data(), expected.data(), size * sizeof(Contact)) == 0)
          << size << " contacts, run " << run;
    }
  }
}

// A host array changes, and grows.
TYPED_TEST_P(MemoryPrimitives, mirrors_follow_the_ranges_that_they_are_told_of) {
  std::vector<std::uint32_t> values = {1, 2, 3, 4};
  typename TypeParam::Backend::template Mirror<std::uint32_t> mirror;
  const auto follow = [&](std::vector<Range> ranges) {
    mirror.follow(this->backend(), Span<const std::uint32_t>(values), Span<const Range>(ranges));
    EXPECT_EQ(TypeParam::copy_out(mirror.data(), values.size()), values);
  };
  follow({{0, 4}});
  values[1] = 20;
  values[3] = 40;
  follow({{1, 2}, {3, 4}});
  values.resize(5000, 7);
  follow({{4, 5000}});
  values[4999] = 8;
  follow({{4999, 5000}, {0, 0}});
  values.resize(3);
  follow({});
}

// A buffer is written once, and again with another length.
TYPED_TEST_P(MemoryPrimitives, the_host_reads_buffers) {
  typename TypeParam::Backend::template Readback<Contact> readback;
  for (const std::uint32_t size : kSizes) {
    const std::vector<Contact> values(size, Contact{});
    auto contacts = this->uploaded(values);
    const auto count = this->one_count(size);
    for (int run = 0; run < 2; ++run) {
      this->backend().for_each("for_each", Count{count.data(), size}, MoveLater{contacts.data()});
      const Span<const Contact> read = readback.read(this->backend(), contacts, size);
      ASSERT_EQ(read.size(), size);
      for (const Contact& contact : read) ASSERT_EQ(contact.time_of_impact, static_cast<float>(run + 1));
    }
  }
}

REGISTER_TYPED_TEST_SUITE_P(MemoryPrimitives, buffers_keep_what_they_are_told_to_when_they_grow,
                            teams_give_every_member_the_same_answers, what_is_launched_comes_back_to_the_host,
                            mirrors_follow_the_ranges_that_they_are_told_of, the_host_reads_buffers);

}  // namespace softcd::test

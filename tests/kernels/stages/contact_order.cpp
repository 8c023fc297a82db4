#include "softcd/stages/contact_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <tuple>
#include <vector>

#include "host_scene.hpp"
#include "random.hpp"
#include "softcd/stages/clear_word.hpp"

namespace softcd::test {
namespace {

TEST(ContactKeys, kind_and_features_survive_packing) {
  for (const ContactKind kind : {ContactKind::vertex_triangle, ContactKind::edge_edge}) {
    const std::uint64_t features = with_kind(kind, (0x7FFFFFFFULL << 32) | 0xFFFFFFFEULL);
    EXPECT_EQ(kind_of(features), kind);
    EXPECT_EQ(first_feature(features), 0x7FFFFFFFU);
    EXPECT_EQ(second_feature(features), 0xFFFFFFFEU);
  }
}

// Keys order contacts by kind, first and second feature, however few bits the scene needs.
TEST(ContactKeys, sort_as_kind_and_features) {
  Random random(1);
  for (const auto& [first_bits, second_bits] : {std::pair(1U, 1U), std::pair(5U, 9U), std::pair(31U, 32U)}) {
    std::vector<FeatureContact> contacts(300);
    for (FeatureContact& contact : contacts) {
      const std::uint64_t first = random.bits() & ((1ULL << std::min(first_bits, 31U)) - 1U);
      const std::uint64_t second = random.bits() & ((1ULL << second_bits) - 1U);
      contact.features = with_kind(static_cast<ContactKind>(random.below(2)), (first << 32) | second);
    }
    std::vector<std::uint64_t> keys(contacts.size());
    std::vector<std::uint32_t> order(contacts.size());
    const MakeContactKey stage{contacts.data(), first_bits, second_bits, keys.data(), order.data()};
    for (std::uint32_t i = 0; i < contacts.size(); ++i) stage(i);
    const auto rank = [&](std::size_t i) {
      const std::uint64_t features = contacts[i].features;
      return std::tuple(kind_of(features), first_feature(features), second_feature(features));
    };
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      ASSERT_EQ(order[i], i);
      for (std::size_t j = 0; j < contacts.size(); ++j) ASSERT_EQ(keys[i] < keys[j], rank(i) < rank(j));
    }
  }
}

/// Returns contacts of different features, among this many of either kind, in no order.
std::vector<FeatureContact> random_contacts(Random& random, std::uint32_t count, std::uint32_t features) {
  std::vector<std::uint64_t> all;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto kind = static_cast<ContactKind>(random.below(2));
    all.push_back(with_kind(kind, (static_cast<std::uint64_t>(random.below(features)) << 32) | random.below(1000000)));
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  for (std::size_t i = all.size(); i > 1; --i) std::swap(all[i - 1], all[random.below(static_cast<std::uint32_t>(i))]);
  std::vector<FeatureContact> contacts(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) contacts[i].features = all[i];
  return contacts;
}

struct Ordered {
  std::vector<std::uint32_t> order;
  std::size_t long_runs;
  std::uint32_t longest;
};

/// Runs the stages of order_contacts in runs, in serial loops.
Ordered order_in_runs(const std::vector<FeatureContact>& contacts, std::uint32_t features) {
  const RunPlan plan = plan_runs(2ULL * features, contacts.size());
  const ContactRuns runs = {features, plan.shift};
  std::vector<std::uint32_t> counts(plan.run_count, 7);
  for (std::uint32_t run = 0; run < plan.run_count; ++run) ClearWord{counts.data()}(run);
  std::vector<std::uint32_t> order(contacts.size());
  Collector<std::uint32_t> longs;
  const auto count = static_cast<std::uint32_t>(contacts.size());
  for (std::uint32_t i = 0; i < count; ++i) CountInRun{runs, contacts.data(), counts.data(), order.data()}(i, longs);
  std::vector<std::uint64_t> begins(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), begins.begin(), std::uint64_t{0});
  std::vector<std::uint64_t> keys(contacts.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    LayIntoRun{runs, contacts.data(), begins.data(), order.data(), keys.data()}(i);
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint64_t place = RankInRun{runs, contacts.data(), begins.data(), counts.data(), keys.data()}.place(i);
    if (place != kNoPlace) order[place] = i;
  }
  return {order, longs.items.size(), *std::max_element(counts.begin(), counts.end())};
}

TEST(ContactRuns, order_contacts_as_their_keys_do) {
  Random random(2);
  for (const auto& [count, features] : {std::pair(0U, 10U), std::pair(1U, 1U), std::pair(100U, 3U),
                                        std::pair(3000U, 5000U), std::pair(500U, 900000U)}) {
    const std::vector<FeatureContact> contacts = random_contacts(random, count, features);
    std::vector<std::uint32_t> expected(contacts.size());
    std::iota(expected.begin(), expected.end(), 0U);
    std::sort(expected.begin(), expected.end(), [&](std::uint32_t i, std::uint32_t j) {
      const auto rank = [&](std::uint32_t k) {
        const std::uint64_t packed = contacts[k].features;
        return std::tuple(kind_of(packed), first_feature(packed), second_feature(packed));
      };
      return rank(i) < rank(j);
    });
    const Ordered ordered = order_in_runs(contacts, features);
    ASSERT_EQ(ordered.long_runs, 0U);
    EXPECT_TRUE(ordered.order == expected) << count << " of " << features;
  }
}

// One run has all contacts: the longest that is ranked in place, and the shortest that is not.
TEST(ContactRuns, of_the_longest_length_are_ordered_and_longer_ones_are_counted) {
  for (const std::uint32_t count : {kLongRun, kLongRun + 1}) {
    std::vector<FeatureContact> contacts(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      contacts[i].features = with_kind(ContactKind::vertex_triangle, count - i);  // the last one first
    }
    std::vector<std::uint64_t> features(count);
    const Ordered ordered = order_in_runs(contacts, 1);
    ASSERT_EQ(ordered.longest, count);
    EXPECT_EQ(ordered.long_runs, count > kLongRun ? 1U : 0U);
    if (count > kLongRun) continue;
    for (std::uint32_t i = 0; i < count; ++i) features[i] = contacts[ordered.order[i]].features;
    EXPECT_TRUE(std::is_sorted(features.begin(), features.end()));
  }
}

TEST(ContactRuns, that_are_too_long_are_counted) {
  Random random(3);
  for (const std::uint32_t features : {1U, 20U}) {
    const Ordered ordered = order_in_runs(random_contacts(random, 5000, features), features);
    EXPECT_GT(ordered.longest, kLongRun);
    EXPECT_GT(ordered.long_runs, 0U);
    EXPECT_LE(ordered.long_runs, 2U * features + 1U);
  }
}

TEST(ContactRuns, are_about_as_many_as_contacts) {
  for (const std::uint64_t features : {1ULL, 1000ULL, 30000000ULL}) {
    for (const std::uint64_t contacts : {0ULL, 1ULL, 1000ULL, 50000000ULL}) {
      const RunPlan plan = plan_runs(features, contacts);
      EXPECT_EQ(plan.run_count, (features >> plan.shift) + 1);
      EXPECT_LE(plan.run_count, 2 * contacts + 1);
      EXPECT_LE(plan.run_count, features + 1);
      EXPECT_TRUE(plan.shift == 0 || plan.run_count > contacts);
    }
  }
}

}  // namespace
}  // namespace softcd::test

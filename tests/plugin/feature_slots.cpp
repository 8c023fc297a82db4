#include "feature_slots.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "random.hpp"

namespace softcd::test {
namespace {

using Features = std::multiset<std::uint64_t>;

/// A list in which one part belongs to triangles with up to 3 features each.
class List {
 public:
  explicit List(std::size_t triangle_count) : of_triangle_(triangle_count) {
    std::vector<FeatureEnds> ends;
    for (std::uint32_t t = 0; t < triangle_count; ++t) {
      for (std::uint32_t i = 0; i < t % 4; ++i) {
        list_.push_back(10 * t + i);
        of_triangle_[t].insert(10 * t + i);
      }
      ends.push_back({0, static_cast<std::uint32_t>(list_.size() - kBegin)});
    }
    list_.resize(list_.size() + list_.size() / 4, kNoFeatures);
    slots_.assign(ends, &FeatureEnds::edge_edge, list_.size() - kBegin);
    unsent_.clear(list_.size());
    sent_ = list_;
  }

  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(of_triangle_.size()); }

  bool add(std::uint32_t triangle, std::uint64_t feature) {
    if (!slots_.add(part(), triangle, feature)) return false;
    if (triangle >= of_triangle_.size()) of_triangle_.resize(triangle + std::size_t{1});
    of_triangle_[triangle].insert(feature);
    return true;
  }
  void drop(std::uint32_t triangle, std::uint64_t remainder) {
    const auto is_stale = [remainder](std::uint64_t feature) { return feature % 3 == remainder; };
    slots_.drop(part(), triangle, is_stale);
    if (triangle < of_triangle_.size()) std::erase_if(of_triangle_[triangle], is_stale);
  }
  std::size_t free_count() const {
    return static_cast<std::size_t>(std::count(list_.begin() + kBegin, list_.end(), kNoFeatures));
  }

  void expect_all() {
    for (const Range& range : unsent_.within(list_.size())) {
      std::copy(list_.begin() + static_cast<std::ptrdiff_t>(range.begin),
                list_.begin() + static_cast<std::ptrdiff_t>(range.end),
                sent_.begin() + static_cast<std::ptrdiff_t>(range.begin));
    }
    unsent_.clear(list_.size());
    EXPECT_EQ(sent_, list_);
    Features listed(list_.begin() + kBegin, list_.end());
    listed.erase(kNoFeatures);
    Features expected;
    for (const Features& features : of_triangle_) expected.insert(features.begin(), features.end());
    EXPECT_EQ(listed, expected);
  }

 private:
  static constexpr std::ptrdiff_t kBegin = 5;  ///< behind the part of another body

  FeaturePart part() { return {{list_.data() + kBegin, list_.size() - kBegin}, kBegin, unsent_}; }

  std::vector<std::uint64_t> list_ = std::vector<std::uint64_t>(kBegin, 77);
  std::vector<std::uint64_t> sent_;
  std::vector<Features> of_triangle_;
  UnsentRanges unsent_;
  FeatureSlots slots_;
};

TEST(FeatureSlots, hold_what_was_added_and_not_dropped) {
  Random random(1);
  for (const std::size_t triangle_count : {0U, 1U, 2U, 40U, 5000U}) {
    SCOPED_TRACE(triangle_count);
    List list(triangle_count);
    list.expect_all();
    for (int step = 0; step < 30; ++step) {
      for (int i = 0; i < 20; ++i) {
        const std::uint32_t triangle = random.below(list.triangle_count() + 2);
        if (random.chance(0.5)) {
          list.drop(triangle, random.below(3));
        } else if (list.free_count() > 0) {
          EXPECT_TRUE(list.add(triangle, random.below(1'000'000)));
        }
      }
      list.expect_all();
    }
  }
}

// Features may be passed on from triangle to triangle in any way.
TEST(FeatureSlots, have_room_as_long_as_a_slot_is_free) {
  Random random(2);
  List list(60);
  for (int round = 0; round < 10; ++round) {
    while (list.free_count() > 0) EXPECT_TRUE(list.add(random.below(70), random.below(1'000'000)));
    EXPECT_FALSE(list.add(random.below(70), 1));
    list.expect_all();
    for (int i = 0; i < 30; ++i) list.drop(random.below(70), random.below(3));
  }
}

}  // namespace
}  // namespace softcd::test

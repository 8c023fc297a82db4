#include "cell_sets.hpp"
#include "enumeration.hpp"
#include "softcd/stages/cell_ranges.hpp"

/// Which entries of a cell are tested with each other.
namespace softcd::test {
namespace {

/// Returns the partners of each entry of sorted keys: the first one and their number.
std::vector<std::pair<std::uint32_t, std::uint32_t>> partners_of(const SceneView& scene, const GridParameters& grid,
                                                                 const std::vector<std::uint32_t>& keys) {
  const auto n = keys.size();
  const Kdop18 volume = volume_of(hull_of({0, 0, 0}, {0, 0, 0}));
  const std::vector<Entry> entries(n, Entry{0, 0});
  std::vector<BoxedEntry> boxed(n);
  std::vector<std::uint32_t> begin(n), count(n);
  struct {
    void push(std::uint32_t /*first*/) {}
  } cells;
  const PrepareEntry<ExactControl, false> stage{scene,          &volume,      nullptr,      &grid,       keys.data(),
                                                entries.data(), boxed.data(), begin.data(), count.data()};
  std::vector<std::pair<std::uint32_t, std::uint32_t>> partners;
  for (std::uint32_t j = 0; j < n; ++j) {
    stage(j, cells);
    partners.emplace_back(begin[j], count[j]);
  }
  return partners;
}

/// Returns the number of ascending sequences of `length` numbers below `values`.
std::uint64_t ascending_sequences(std::uint64_t length, std::uint64_t values) {
  std::uint64_t count = 1;
  for (std::uint64_t i = 1; i <= length; ++i) count = count * (values + i - 1) / i;
  return count;
}

/// Calls visit for every ascending sequence of keys in two cells.
template <class Visit>
void for_each_sequence(std::size_t length, std::vector<std::uint32_t>& keys, Visit visit) {
  if (keys.size() == length) return visit();
  for (std::uint32_t key = keys.empty() ? 0 : keys.back(); key < 16; ++key) {
    keys.push_back(key);
    for_each_sequence(length, keys, visit);
    keys.pop_back();
  }
}

constexpr std::size_t kMostEntries = 6;

// Statement 15. Of two entries of a cell whose control bits let them be tested, the later one has the earlier one among
// its partners, once. That is so for all sorted entries of two cells, up to six. No entry has a partner in another
// cell.
TEST(Partners, are_all_earlier_entries_that_may_be_tested) {
  std::uint64_t expected = 0;
  for (std::size_t n = 1; n <= kMostEntries; ++n) expected += ascending_sequences(n, 16);
  Enumeration sequences(expected);
  CellScene scene(1);
  for (std::size_t n = 1; n <= kMostEntries; ++n) {
    std::vector<std::uint32_t> keys;
    for_each_sequence(n, keys, [&] {
      const auto partners = partners_of(scene.view(), scene.grid(), keys);
      for (std::uint32_t j = 0; j < n; ++j) {
        const auto [first, count] = partners[j];
        ASSERT_LE(first + count, j);
        for (std::uint32_t i = 0; i < j; ++i) {
          const bool is_partner = first <= i && i < first + count;
          const bool shares_cell = keys[i] / 8 == keys[j] / 8;
          const std::uint32_t k_of_either = (7U - keys[i] % 8) | (7U - keys[j] % 8);
          ASSERT_TRUE(is_partner || !shares_cell || k_of_either != 7U) << i << ' ' << j;
          ASSERT_TRUE(shares_cell || !is_partner) << i << ' ' << j;
        }
      }
      sequences.next();
    });
    if (testing::Test::HasFatalFailure()) return;
  }
}

// Statement 16. Without self-collision, of two entries of different bodies the later one has the earlier one among its
// partners: for two bodies of up to 40, sorted by their ranks.
TEST(Partners, are_of_all_other_bodies) {
  Enumeration pairs(std::uint64_t{40} * 41 * 81 / 6 - 1);
  for (std::uint32_t body_count = 2; body_count <= 40; ++body_count) {
    CellScene scene(1);
    scene.view().self_collision = false;
    scene.view().body_count = body_count;
    for (std::uint32_t a = 0; a < body_count; ++a) {
      for (std::uint32_t b = 0; b < body_count; ++b) {
        const std::uint32_t ranks[2] = {entry_rank(scene.view(), a, 7), entry_rank(scene.view(), b, 7)};
        const std::vector<std::uint32_t> keys = {entry_key(0, std::min(ranks[0], ranks[1])),
                                                 entry_key(0, std::max(ranks[0], ranks[1]))};
        const auto partners = partners_of(scene.view(), scene.grid(), keys);
        if (a != b) {
          ASSERT_EQ(partners[1].second, 1U) << a << ' ' << b << " of " << body_count;
        }
        pairs.next();
      }
    }
  }
}

}  // namespace
}  // namespace softcd::test

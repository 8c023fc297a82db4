#include "softcd/stages/entry_bins.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "host_scene.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

/// A list that only gives places.
struct Places {
  struct Room {
    std::uint64_t first;
    std::uint64_t begin() const { return first; }
  };
  std::uint64_t count = 0;

  Room allocate(std::uint32_t more) {
    count += more;
    return {count - more};
  }
};

/// Entries that are ready for their tests. Entry i belongs to triangle i.
struct Prepared {
  std::vector<std::uint32_t> keys, begin, count;
  std::vector<BoxedEntry> boxed;
  std::size_t cells = 0;

  explicit Prepared(std::size_t size) : keys(size), begin(size), count(size), boxed(size) {}

  /// Returns the entries that each entry is tested with.
  std::vector<std::vector<std::uint32_t>> partners() const {
    std::vector<std::vector<std::uint32_t>> all(keys.size());
    for (std::size_t j = 0; j < keys.size(); ++j) {
      for (std::uint32_t k = 0; k < count[j]; ++k) all[boxed[j].root].push_back(boxed[begin[j] + k].root);
      std::sort(all[boxed[j].root].begin(), all[boxed[j].root].end());
    }
    return all;
  }
};

/// Runs the stages in serial loops.
class Entries {
 public:
  Entries(const SceneView& scene, const std::vector<std::uint32_t>& keys)
      : scene_(scene), keys_(keys), volumes_(keys.size(), empty_kdop()) {
    for (std::uint32_t i = 0; i < keys.size(); ++i) {
      entries_.push_back({i, 0});
      extend(volumes_[i], Vec3f{0.5F, 0.5F, 0.5F});
    }
  }

  Prepared sorted() const {
    std::vector<std::uint32_t> order(keys_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](auto i, auto j) { return keys_[i] < keys_[j]; });
    std::vector<std::uint32_t> keys;
    std::vector<Entry> entries;
    for (const std::uint32_t i : order) {
      keys.push_back(keys_[i]);
      entries.push_back(entries_[i]);
    }
    Prepared prepared(keys.size());
    Collector<std::uint32_t> cells;
    const auto stage = prepare(keys.data(), entries.data(), prepared);
    for (std::uint32_t j = 0; j < keys.size(); ++j) stage(j, cells);
    prepared.keys = keys;
    prepared.cells = cells.items.size();
    return prepared;
  }

  Prepared in_bins(EntryBins bins, std::uint64_t& long_bins) const {
    const auto size = static_cast<std::uint32_t>(keys_.size());
    std::vector<std::uint32_t> counts(bins.count(), 0);
    std::vector<std::uint32_t> places(size);
    std::vector<std::uint32_t> listed_keys(size);
    std::vector<Entry> listed(size);
    const BinTarget target = {{listed_keys.data(), listed.data()}, bins, counts.data(), places.data(), &long_bins};
    for (std::uint32_t i = 0; i < size; ++i) target.store(i, {keys_[i], entries_[i]});
    std::vector<std::uint64_t> begins(bins.count());
    Places all;
    for (std::uint32_t bin = 0; bin < bins.count(); ++bin) PlaceBin{counts.data(), begins.data()}(bin, all);
    std::vector<std::uint32_t> laid_keys(size);
    std::vector<Entry> laid(size);
    const EntryTarget in_bins = {laid_keys.data(), laid.data()};
    for (std::uint32_t i = 0; i < size; ++i) {
      LayIntoBin{bins, begins.data(), places.data(), listed_keys.data(), listed.data(), in_bins}(i);
    }
    Prepared prepared(size);
    Collector<std::uint32_t> cells;
    const PrepareInBin<ExactControl, false> stage{prepare(laid_keys.data(), laid.data(), prepared), bins, begins.data(),
                                                  counts.data(), prepared.keys.data()};
    for (std::uint32_t j = 0; j < size; ++j) stage(j, cells);
    prepared.cells = cells.items.size();
    return prepared;
  }

 private:
  PrepareEntry<ExactControl, false> prepare(const std::uint32_t* keys, const Entry* entries, Prepared& to) const {
    return {scene_, volumes_.data(), nullptr, &grid_, keys, entries, to.boxed.data(), to.begin.data(), to.count.data()};
  }

  SceneView scene_;
  std::vector<std::uint32_t> keys_;
  std::vector<Entry> entries_;
  std::vector<Kdop18> volumes_;
  GridParameters grid_{1.0F, 1.0F, 0.0F, 3, 3};
};

std::vector<std::uint32_t> random_entry_keys(std::uint32_t count, std::uint32_t cell_count) {
  Random random(count);
  std::vector<std::uint32_t> keys;
  for (std::uint32_t i = 0; i < count; ++i) keys.push_back(entry_key(random.below(cell_count), random.below(8)));
  return keys;
}

SceneView scene_with(std::uint32_t body_count, bool self_collision) {
  SceneView scene;
  scene.body_count = body_count;
  scene.self_collision = self_collision;
  return scene;
}

// Serial loops keep the order of equal keys, like the sort.
TEST(EntryBins, partners_are_those_of_sorted_entries) {
  for (const auto& [body_count, self_collision] : {std::pair(1U, true), std::pair(8U, false), std::pair(9U, false)}) {
    for (const auto& [count, cell_count] : {std::pair(1U, 1U), std::pair(300U, 1U), std::pair(5000U, 700U)}) {
      const Entries entries(scene_with(body_count, self_collision), random_entry_keys(count, cell_count));
      const Prepared expected = entries.sorted();
      for (const int bits : {5, 12}) {
        std::uint64_t long_bins = 0;
        const Prepared prepared = entries.in_bins({bits}, long_bins);
        EXPECT_EQ(long_bins, 0U);
        EXPECT_EQ(prepared.cells, expected.cells);
        EXPECT_TRUE(prepared.partners() == expected.partners()) << count << " entries, " << bits << " bits";
        std::vector<std::uint32_t> keys = prepared.keys;
        std::sort(keys.begin(), keys.end());
        EXPECT_TRUE(keys == expected.keys);
      }
    }
  }
}

// All pairs of a cell, in any order, are enumerated once.
TEST(EntryBins, entries_of_one_rank_are_tested_with_each_other_once) {
  const std::uint32_t count = 100;
  const Entries entries(scene_with(1, true), std::vector<std::uint32_t>(count, entry_key(77, 0)));
  std::uint64_t long_bins = 0;
  const Prepared prepared = entries.in_bins({3}, long_bins);
  EXPECT_EQ(prepared.cells, 1U);
  EXPECT_EQ(std::accumulate(prepared.count.begin(), prepared.count.end(), 0U), count * (count - 1) / 2);
}

TEST(EntryBins, that_are_too_long_are_counted) {
  for (const std::uint32_t count : {kLongBin, kLongBin + 1}) {
    std::uint64_t long_bins = 0;
    const Entries entries(scene_with(1, true), std::vector<std::uint32_t>(count, entry_key(5, 1)));
    entries.in_bins({2}, long_bins);
    EXPECT_EQ(long_bins, count > kLongBin ? 1U : 0U);
  }
}

TEST(EntryBins, are_an_eighth_to_a_fourth_of_the_entries) {
  for (const std::uint64_t entries : {std::uint64_t{100}, std::uint64_t{40000}, std::uint64_t{5000001}}) {
    const std::uint64_t bins = plan_bins(entries).count();
    EXPECT_GE(8 * bins, entries);
    EXPECT_LT(4 * bins, entries);
  }
}

// Cells in a row, as of a road, must not share bins.
TEST(EntryBins, of_neighbouring_cells_differ) {
  const EntryBins bins = {12};
  for (const Cell step : {Cell{1, 0, 0}, Cell{0, 1, 0}, Cell{0, 0, 1}}) {
    std::vector<std::uint32_t> counts(bins.count(), 0);
    for (int i = 0; i < 1000; ++i) ++counts[bins.bin(entry_key(cell_index({i * step.x, i * step.y, i * step.z}), 0))];
    EXPECT_LE(*std::max_element(counts.begin(), counts.end()), 4U);
  }
}

}  // namespace
}  // namespace softcd::test

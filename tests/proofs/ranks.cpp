#include <algorithm>
#include <cstdlib>

#include "cell_sets.hpp"
#include "enumeration.hpp"
#include "softcd/stages/patches.hpp"
#include "softcd/stages/shared_pairs.hpp"

/// Several ranks, each with a range of cells' numbers, find each pair once between them.
namespace softcd::test {
namespace {

constexpr CellBox kBox = {2, 2, 2};

/// Offsets of cells: none, and one with which the numbers of kBox begin again between its layers.
constexpr std::uint32_t kOffsets[] = {0, kCellCount - kCellLayer};

/// Returns three ranks' parts for each two cuts between the numbers of a box's cells, and before and behind all.
std::vector<std::vector<Partition>> partitions_of(const CellBox& box, std::uint32_t offset) {
  std::vector<std::uint32_t> cuts = {0, kCellCount};
  for (std::uint32_t i = 0; i < box.count(); ++i) {
    const std::uint32_t number = moved_cell(cell_index(box.cell(i)), offset);
    cuts.push_back(number);
    cuts.push_back(number + 1);
  }
  std::sort(cuts.begin(), cuts.end());
  cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
  std::vector<std::vector<Partition>> partitions;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    for (std::size_t j = i; j < cuts.size(); ++j) {
      partitions.push_back({{{0, 3}, 0, cuts[i]}, {{1, 3}, cuts[i], cuts[j]}, {{2, 3}, cuts[j], kCellCount}});
    }
  }
  return partitions;
}

/// Returns all integer DOPs of two cells of the box, each once.
std::vector<IntegerDop> hulls_in(const CellBox& box) {
  std::vector<IntegerDop> hulls;
  for (std::uint32_t i = 0; i < box.count(); ++i) {
    for (std::uint32_t j = i; j < box.count(); ++j) hulls.push_back(hull_of(box.cell(i), box.cell(j)));
  }
  return hulls;
}

/// Whether the entries of all ranks together are those without ranks. Each rank has entries in its cells only.
template <class Register>
bool ranks_have_each_entry_once(const std::vector<Partition>& ranks, Register register_for) {
  const auto by_key = [](const KeyedEntry& a, const KeyedEntry& b) { return a.key < b.key; };
  const auto are_equal = [](const KeyedEntry& a, const KeyedEntry& b) {
    return a.key == b.key && a.entry.root == b.entry.root && a.entry.bits == b.entry.bits;
  };
  std::vector<KeyedEntry> whole = register_for(Partition{});
  std::vector<KeyedEntry> of_ranks;
  for (const Partition& rank : ranks) {
    const std::vector<KeyedEntry> its = register_for(rank);
    if (!std::all_of(its.begin(), its.end(), [&](const KeyedEntry& e) { return rank.has(key_cell(e.key)); }))
      return false;
    of_ranks.insert(of_ranks.end(), its.begin(), its.end());
  }
  std::sort(whole.begin(), whole.end(), by_key);
  std::sort(of_ranks.begin(), of_ranks.end(), by_key);
  return std::equal(whole.begin(), whole.end(), of_ranks.begin(), of_ranks.end(), are_equal);
}

// Statement 17. Each entry of an element is that of exactly one rank, with the same control bits that it has without
// ranks. So a pair is tested by one rank where it is tested once without ranks. For whole elements in 3 x 2 x 2 cells,
// and for all sets of cells of a split triangle in 2 x 2 x 2.
TEST(Ranks, have_each_entry_once) {
  const CellBox box = {3, 2, 2};
  const std::vector<IntegerDop> hulls = hulls_in(box);
  std::uint64_t expected = 0;
  for (const std::uint32_t offset : kOffsets) {
    expected += hulls.size() * partitions_of(box, offset).size() + 256 * partitions_of(kBox, offset).size();
  }
  Enumeration parts(expected);
  for (const std::uint32_t offset : kOffsets) {
    CellScene scene(1, offset);
    for (const auto& ranks : partitions_of(box, offset)) {
      for (const IntegerDop& hull : hulls) {
        const auto register_for = [&](const Partition& rank) { return scene.register_whole(0, hull, rank); };
        ASSERT_TRUE(ranks_have_each_entry_once(ranks, register_for));
        parts.next();
      }
    }
    MarkedCells marked(0, kBox.corner, kBox.width, kBox.height, kBox.depth);
    for (std::uint32_t set = 0; set < kBox.set_count(); ++set) {
      marked.mark_set(kBox, set);
      for (const auto& ranks : partitions_of(kBox, offset)) {
        const auto register_for = [&](const Partition& rank) { return marked.register_all(scene, rank); };
        ASSERT_TRUE(ranks_have_each_entry_once(ranks, register_for)) << set;
        parts.next();
      }
    }
  }
}

// Statement 18. A rank that has one cell of an element's box registers it: for each cell of a box of the largest size,
// also where numbers begin again within the box.
TEST(Ranks, see_that_they_have_one_cell_of_a_box) {
  constexpr int kSide = kMaxSpan;
  Enumeration cells(std::uint64_t{2} * kSide * kSide * kSide);
  for (const std::uint32_t offset : {0U, kCellCount - kCellLayer * (kSide / 2) - kCellRow * (kSide / 2) - kSide / 2}) {
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
      const Cell cell = {i % kSide, i / kSide % kSide, i / kSide / kSide};
      const std::uint32_t number = moved_cell(cell_index(cell), offset);
      const Partition rank{{0, 2}, number, number + 1};
      ASSERT_TRUE(rank.may_have({0, 0, 0}, {kSide - 1, kSide - 1, kSide - 1}, offset)) << i;
      cells.next();
    }
  }
}

/// Elements with any cells of kBox, and their entries for each rank.
class ElementsOfRanks {
 public:
  explicit ElementsOfRanks(std::uint32_t offset) : scene_(2, offset), offset_(offset) {
    for (std::uint32_t set = 0; set < kBox.set_count(); ++set) {
      MarkedCells marked(0, kBox.corner, 2, 2, 2);
      marked.mark_set(kBox, set);
      entries_.emplace_back(kBox, marked.register_all(scene_, {}), offset);
      marked_.push_back(marked);
    }
    IntegerDop box{};
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      box.lo[axis] = axis < 3 ? 0 : -4;
      box.hi[axis] = axis < 3 ? 1 : 4;
    }
    scene_.volumes() = {volume_of(box), volume_of(box)};
  }

  /// Returns the number of ranks that keep the pair of two split triangles.
  int keepers(std::uint32_t a, std::uint32_t b, const std::vector<Partition>& ranks) {
    const SplitBox boxes[2] = {marked_[a].box(), marked_[b].box()};
    const std::uint64_t offsets[2] = {0, boxes[0].words()};
    std::vector<std::uint32_t> words;
    for (const std::uint32_t set : {a, b}) {
      const SplitBits bits = marked_[set].bits();
      words.insert(words.end(), bits.words, bits.words + bits.capacity);
    }
    const std::uint32_t split_of[2] = {0, 1};
    const std::uint64_t pair = pair_key(0, 1);
    int keepers = 0;
    for (const Partition& rank : ranks) {
      if (!finds(a, b, rank)) continue;
      struct {
        int count = 0;
        void push(std::uint64_t /*pair*/) { ++count; }
      } kept, patches;
      KeepOwnFirst{&pair,
                   scene_.view(),
                   rank,
                   scene_.volumes().data(),
                   &scene_.grid(),
                   split_of,
                   {boxes, offsets, words.data(), words.size()}}(0, kept, patches);
      keepers += kept.count;
    }
    return keepers;
  }

 private:
  /// Whether the rank tests the pair in one of its cells.
  bool finds(std::uint32_t a, std::uint32_t b, const Partition& rank) const {
    for (std::uint32_t common = a & b; common != 0U; common &= common - 1U) {
      const int i = lowest_bit(common);
      if (!rank.has(moved_cell(cell_index(kBox.cell(static_cast<std::uint32_t>(i))), offset_))) continue;
      const Entry of_a = {0, entries_[a].bits[i]}, of_b = {1, entries_[b].bits[i]};
      if (ExactControl::judge(0, of_a, of_b) == Verdict::execute_and_flag) return true;
    }
    return false;
  }

  CellScene scene_;
  std::uint32_t offset_;
  std::vector<MarkedCells> marked_;
  std::vector<ControlledCells> entries_;
};

// Statement 19. Of the ranks that find a flagged pair, exactly one keeps it: for all sets of cells of both in a box of
// 2 x 2 x 2 cells, and all ways to cut its cells into three ranks' parts.
TEST(Ranks, keep_each_flagged_pair_once) {
  std::uint64_t expected = 0;
  for (const std::uint32_t offset : kOffsets) expected += 256 * 256 * partitions_of(kBox, offset).size();
  Enumeration pairs(expected);
  for (const std::uint32_t offset : kOffsets) {
    ElementsOfRanks elements(offset);
    const auto partitions = partitions_of(kBox, offset);
    for (std::uint32_t a = 0; a < kBox.set_count(); ++a) {
      for (std::uint32_t b = 0; b < kBox.set_count(); ++b) {
        for (const auto& ranks : partitions) {
          ASSERT_EQ(elements.keepers(a, b, ranks), (a & b) != 0U ? 1 : 0) << a << ' ' << b << ' ' << offset;
          pairs.next();
        }
      }
    }
  }
}

// Statement 20. The first common cell is the lowest one: for each two cells that a split and a whole element, or two
// split ones, have in common in rows of the greatest length, wherever the row of the one begins.
TEST(FirstCommonCell, is_the_lowest_one_in_rows_of_words) {
  std::uint64_t expected = 0;
  for (const int begin : {-33, -32, -31, -1, 0, 1, 31, 32, 33}) {
    const int common = kMaxSpan - std::abs(begin);
    expected += 2 * static_cast<std::uint64_t>(common * (common + 1) / 2);
  }
  Enumeration rows(expected);
  const auto row_of = [](int begin) {
    IntegerDop row{};
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      row.lo[axis] = axis == 0 ? begin : (axis < 3 ? 0 : -1000);
      row.hi[axis] = axis == 0 ? begin + kMaxSpan - 1 : (axis < 3 ? 0 : 1000);
    }
    return row;
  };
  for (const int begin : {-33, -32, -31, -1, 0, 1, 31, 32, 33}) {
    MarkedCells a(0, {0, 0, 0}, kMaxSpan, 1, 1), b(1, {begin, 0, 0}, kMaxSpan, 1, 1);
    const Kdop18 volumes[2] = {volume_of(row_of(0)), volume_of(row_of(begin))};
    for (int first = std::max(begin, 0); first < std::min(begin, 0) + kMaxSpan; ++first) {
      for (int second = first; second < std::min(begin, 0) + kMaxSpan; ++second) {
        for (const bool is_whole : {false, true}) {
          a.clear();
          b.clear();
          for (const int x : {first, second}) {
            a.mark({x, 0, 0});
            b.mark({x, 0, 0});
          }
          const TriangleCells cells_a(volumes[0], 1.0F, 0, a.bits());
          const TriangleCells cells_b(volumes[1], 1.0F, is_whole ? kNoIndex : 0, b.bits());
          Cell cell{};
          ASSERT_TRUE(first_common_cell(cells_a, cells_b, cell));
          ASSERT_EQ(cell.x, first) << begin << ' ' << second << ' ' << is_whole;
          rows.next();
        }
      }
    }
  }
}

// Statement 21. One rank has the pair of a patch with itself.
TEST(Ranks, have_a_patch_and_itself_once) {
  const CellBox box = {3, 2, 2};
  const std::vector<IntegerDop> hulls = hulls_in(box);
  std::uint64_t expected = 0;
  for (const std::uint32_t offset : kOffsets) expected += hulls.size() * partitions_of(box, offset).size();
  Enumeration parts(expected);
  const std::uint32_t triangles[kPatchSize] = {0, kNoIndex, kNoIndex, kNoIndex, kNoIndex, kNoIndex, kNoIndex, kNoIndex};
  for (const std::uint32_t offset : kOffsets) {
    CellScene scene(2, offset);
    scene.view().triangle_count = 1;
    scene.view().patch_count = 1;
    scene.view().patch_triangles = triangles;
    for (const auto& ranks : partitions_of(box, offset)) {
      for (const IntegerDop& hull : hulls) {
        scene.volumes() = {volume_of(hull), volume_of(hull)};
        struct {
          int count = 0;
          void push(std::uint64_t /*item*/) { ++count; }
        } loose, itself;
        for (const Partition& rank : ranks) {
          const RegisterPatch stage{{scene.view(), scene.volumes().data(), scene.shapes().data(), &scene.grid(), rank}};
          const Registration work = stage.load_item(0);
          EntrySink entries;
          for (std::uint32_t part = 0; part < work.part_count(); ++part) stage(work, part, entries, loose, itself);
        }
        ASSERT_EQ(itself.count, 1);
        ASSERT_EQ(loose.count, 0);
        parts.next();
      }
    }
  }
}

// Statement 22. Work outside of cells, divided by numbers, is done once: for up to 1000 items and 64 ranks.
TEST(Ranks, divide_numbers) {
  Enumeration works(1001 * 64);
  for (std::uint64_t work = 0; work <= 1000; ++work) {
    for (std::uint32_t count = 1; count <= 64; ++count) {
      std::uint64_t next = 0;
      for (std::uint32_t rank = 0; rank < count; ++rank) {
        ASSERT_EQ((Share{rank, count}.begin(work)), next) << work << ' ' << rank << " of " << count;
        ASSERT_GE((Share{rank, count}.end(work)), next);
        next = Share{rank, count}.end(work);
      }
      ASSERT_EQ(next, work);
      works.next();
    }
  }
}

}  // namespace
}  // namespace softcd::test

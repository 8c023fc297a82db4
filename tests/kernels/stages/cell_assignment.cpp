#include "softcd/stages/cell_assignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "host_scene.hpp"
#include "lower_neighbour.hpp"
#include "split_triangles.hpp"

namespace softcd::test {
namespace {

Mesh uneven_soup() {
  SoupOptions options;
  options.triangle_count = 300;
  options.half_extent = 3.0;
  options.largest = 4.0;
  options.size_ratio = 100.0;
  options.degenerate_share = 0.05;
  return triangle_soup(options);
}

class CellAssignment : public testing::Test {
 protected:
  CellAssignment() : host_({{uneven_soup(), {}, 0.01F}}, false), scene_(host_.view()), bounds_(scene_) {}

  void register_all(const GridParameters& grid, bool subdivision) {
    const RegisterTriangle stage{{scene_, bounds_.volumes.data(), bounds_.shapes.data(), &grid, {}}, subdivision};
    for (std::uint32_t t = 0; t < scene_.triangle_count; ++t) {
      const Registration work = stage.load_item(t);
      for (std::uint32_t part = 0; part < work.part_count(); ++part) stage(work, part, entries_, splits_, bigs_);
    }
  }

  HostScene host_;
  SceneView scene_;
  HostVolumes bounds_;
  Collector<KeyedEntry> entries_;
  Collector<SplitRoot> splits_;
  Collector<std::uint32_t> bigs_;
};

TEST_F(CellAssignment, whole_triangles_are_in_every_cell_of_their_volume) {
  const GridParameters parameters = grid_of(0.5F);
  register_all(parameters, false);
  EXPECT_TRUE(splits_.items.empty());
  EXPECT_TRUE(bigs_.items.empty());
  std::map<std::uint32_t, std::map<std::uint32_t, KeyedEntry>> by_triangle;
  for (const KeyedEntry& entry : entries_.items) {
    EXPECT_TRUE(by_triangle[entry.entry.root].emplace(key_cell(entry.key), entry).second) << "twice in a cell";
  }
  EXPECT_EQ(by_triangle.size(), scene_.triangle_count);
  for (const auto& one : by_triangle) {
    const std::uint32_t t = one.first;
    const std::map<std::uint32_t, KeyedEntry>& entries = one.second;
    const IntegerDop dop = integer_dop(bounds_.volumes[t], parameters.inverse_cell_size);
    std::size_t count = 0;
    for_each_cell(dop, [&](Cell c) {
      ++count;
      const auto found = entries.find(cell_index(c));
      ASSERT_NE(found, entries.end());
      std::uint32_t mask = 0;
      for (int bit = 0; bit < 13; ++bit) {
        if (entries.contains(cell_index(lower_neighbour(c, bit)))) mask |= 1U << bit;
      }
      const Entry& entry = found->second.entry;
      EXPECT_EQ(entry.bits & 0x1FFFU, mask);
      EXPECT_EQ(key_rank(found->second.key), 7U - missing_face_neighbours(mask));
      EXPECT_EQ((entry.bits >> 24) & 63U, scene_.ownership[t] & 63U);
      EXPECT_EQ((entry.bits >> 14) & 1U, dop.span() <= 2 ? 1U : 0U);
      EXPECT_EQ((entry.bits >> 13) & 1U, 0U) << "not split";
    });
    EXPECT_EQ(count, entries.size());
  }
}

TEST_F(CellAssignment, every_triangle_is_registered_split_or_big) {
  register_all(grid_of(0.2F), true);
  std::set<std::uint32_t> whole;
  for (const KeyedEntry& entry : entries_.items) whole.insert(entry.entry.root);
  EXPECT_EQ(whole.size() + splits_.items.size() + bigs_.items.size(), scene_.triangle_count);
  EXPECT_FALSE(splits_.items.empty());
  for (const SplitRoot& split : splits_.items) {
    EXPECT_FALSE(whole.contains(split.root));
    EXPECT_GT(split.level, 0);
    EXPECT_GT(bounds_.shapes[split.root].radius, 0.1F);
  }
}

TEST_F(CellAssignment, triangles_too_large_for_the_grid_are_listed) {
  register_all(grid_of(0.004F), true);
  EXPECT_FALSE(bigs_.items.empty());
  for (const std::uint32_t t : bigs_.items) {
    EXPECT_TRUE(bounds_.shapes[t].flags & kBigTriangle);
    EXPECT_GT(bounds_.shapes[t].radius, 0.004F * 32.0F);
  }
}

TEST_F(CellAssignment, triangles_are_split_where_their_cells_cost_less_than_tests_against_all) {
  GridParameters parameters = grid_of(0.1F);
  register_all(parameters, true);
  const std::size_t most = splits_.items.size();
  EXPECT_GT(most, 20U);
  EXPECT_TRUE(bigs_.items.empty());
  std::size_t before = most;
  for (const std::uint32_t active : {1U << 14, 1U << 11, 1U << 9}) {
    splits_.items.clear();
    bigs_.items.clear();
    parameters.active_elements = active;
    register_all(parameters, true);
    EXPECT_EQ(splits_.items.size() + bigs_.items.size(), most);
    EXPECT_LT(splits_.items.size(), before) << active;
    before = splits_.items.size();
    float largest_split = 0.0F;
    float smallest_big = INFINITY;
    for (const SplitRoot& split : splits_.items)
      largest_split = std::max(largest_split, bounds_.shapes[split.root].radius);
    for (const std::uint32_t t : bigs_.items) smallest_big = std::min(smallest_big, bounds_.shapes[t].radius);
    EXPECT_LT(largest_split, smallest_big);
  }
}

TEST_F(CellAssignment, whole_triangles_stay_in_the_grid_where_their_cells_cost_less_than_tests_against_all) {
  GridParameters parameters = grid_of(0.1F);
  parameters.active_elements = 256;
  register_all(parameters, false);
  EXPECT_FALSE(bigs_.items.empty());
  std::map<std::uint32_t, std::size_t> cells_of;
  for (const KeyedEntry& entry : entries_.items) ++cells_of[entry.entry.root];
  EXPECT_EQ(cells_of.size() + bigs_.items.size(), scene_.triangle_count);
  const std::size_t bound = 3 * 256 / static_cast<std::size_t>(kTestsPerCell);
  for (const auto& [t, cells] : cells_of) EXPECT_LE(cells, bound) << t;
}

// A split triangle's entries: the union of its children's cells around it, once each, with the mask of that union.
void expect_the_cells_of_children(const SceneView& scene, const HostVolumes& bounds,
                                  const std::vector<SplitRoot>& splits, const GridParameters& parameters) {
  Collector<KeyedEntry> entries;
  register_split_triangles(scene, bounds.volumes.data(), bounds.shapes.data(), splits, parameters, entries);

  std::map<std::uint32_t, std::set<std::uint32_t>> expected;
  for (const SplitRoot& split : splits) {
    const TriangleMotion motion = load_triangle(scene, split.root);
    const IntegerDop own = integer_dop(bounds.volumes[split.root], parameters.inverse_cell_size);
    const auto is_around = [&](Cell c) {
      return own.lo[0] <= c.x && c.x <= own.hi[0] && own.lo[1] <= c.y && c.y <= own.hi[1] && own.lo[2] <= c.z &&
             c.z <= own.hi[2];
    };
    for (std::uint32_t child = 0; child < split.child_count(); ++child) {
      const Kdop18 volume =
          child_volume(motion, static_cast<int>(split.level), child, bounds.shapes[split.root].growth);
      for_each_cell(integer_dop(volume, parameters.inverse_cell_size), [&](Cell c) {
        if (is_around(c)) expected[split.root].insert(cell_index(c));
      });
    }
  }
  std::size_t expected_count = 0;
  for (const auto& [root, of_root] : expected) expected_count += of_root.size();
  EXPECT_EQ(entries.items.size(), expected_count);
  for (const KeyedEntry& entry : entries.items) {
    const std::set<std::uint32_t>& of_root = expected.at(entry.entry.root);
    const std::uint32_t index = key_cell(entry.key);
    ASSERT_TRUE(of_root.contains(index));
    const Cell c = cell_near(index, {0, 0, 0});
    std::uint32_t mask = 0;
    for (int bit = 0; bit < 13; ++bit) {
      if (of_root.contains(cell_index(lower_neighbour(c, bit)))) mask |= 1U << bit;
    }
    EXPECT_EQ(entry.entry.bits & 0x1FFFU, mask);
    EXPECT_EQ((entry.entry.bits >> 13) & 1U, 1U) << "split";
  }
}

TEST_F(CellAssignment, split_triangles_are_in_every_cell_of_their_children) {
  const GridParameters parameters = grid_of(0.3F);
  register_all(parameters, true);
  ASSERT_GT(splits_.items.size(), 10U);
  expect_the_cells_of_children(scene_, bounds_, splits_.items, parameters);
}

/// Returns one triangle of about this many units, along x and a little of y and z.
HostScene scene_of_one_triangle(double length) {
  const Mesh mesh{{{{0, 1, 2}}}, {{-0.5 * length, 0, 0}, {0.5 * length, 3, 1}, {0, 2, 4}}};
  return HostScene({{mesh, {}, 0.0F}}, false);
}

// Bits of cells lie in words of 32 along x: neighbours are in other words, too.
TEST(SplitCells, go_on_from_one_word_of_bits_to_the_next) {
  const HostScene host = scene_of_one_triangle(80.0);
  const SceneView scene = host.view();
  expect_the_cells_of_children(scene, HostVolumes(scene), {{0, 5}}, grid_of(1.0F));
}

// Entries of one triangle that are further apart might have the numbers of one cell.
TEST(CellsOfATriangle, are_no_further_apart_than_their_numbers_tell) {
  for (const double length : {0.9 * kMaxSpan, 1.1 * kMaxSpan}) {
    const HostScene host = scene_of_one_triangle(length);
    const SceneView scene = host.view();
    HostVolumes bounds(scene);
    const GridParameters grid = grid_of(1.0F);
    const RegisterTriangle stage{{scene, bounds.volumes.data(), bounds.shapes.data(), &grid, {}},
                                 /*subdivision=*/false};
    EXPECT_EQ(stage.load_item(0).placement, length < kMaxSpan ? Placement::whole : Placement::big) << length;
  }
}

}  // namespace
}  // namespace softcd::test

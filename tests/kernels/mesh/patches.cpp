#include "softcd/mesh/patches.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "mesh_generators.hpp"

namespace softcd::test {
namespace {

PatchOrder patches_of(const Mesh& mesh, Span<const Segment> segments = {}) {
  return build_topology(mesh.triangles, static_cast<std::uint32_t>(mesh.positions.size()), segments).patches;
}

std::size_t patch_count(const PatchOrder& patches) {
  return patches.triangles.size() / kPatchSize;
}

void expect_each_triangle_once(const PatchOrder& patches, std::size_t triangle_count) {
  ASSERT_EQ(patches.triangles.size() % kPatchSize, 0U);
  EXPECT_EQ(patches.triangle_count, triangle_count);
  std::vector<int> times(triangle_count, 0);
  for (std::size_t i = 0; i < patches.triangles.size(); ++i) {
    const std::uint32_t t = patches.triangles[i];
    const bool is_first = i % kPatchSize == 0;
    const bool is_last_of_fewer = !is_first && patches.triangles[i - 1] == kNoIndex;
    if (t == kNoIndex) {
      EXPECT_FALSE(is_first) << "patch " << i / kPatchSize << " has no triangle";
      continue;
    }
    EXPECT_FALSE(is_last_of_fewer) << "patch " << i / kPatchSize << " has a gap";
    ASSERT_LT(t, triangle_count);
    ++times[t];
  }
  EXPECT_TRUE(std::all_of(times.begin(), times.end(), [](int count) { return count == 1; }));
}

TEST(PatchOrder, has_each_triangle_once) {
  SoupOptions soup;
  soup.joined_share = 0.5;
  soup.degenerate_share = 0.2;
  Mesh fan;
  for (std::uint32_t i = 0; i < 100; ++i) fan.triangles.push_back({{0, 1, i + 2}});
  fan.positions.resize(102);
  for (const Mesh& mesh : {grid_cloth(23, 17, 0.1), icosphere(3, 1.0), triangle_soup(soup), fan, Mesh{}}) {
    expect_each_triangle_once(patches_of(mesh), mesh.triangles.size());
  }
}

TEST(PatchOrder, has_each_segment_once) {
  const std::vector<Segment> segments = {{{0, 1}}, {{1, 2}}, {{2, 3}}, {{3, 3}}};
  Mesh cloth = grid_cloth(4, 4, 0.1);
  expect_each_triangle_once(patches_of(cloth, segments), cloth.triangles.size() + segments.size());
}

TEST(PatchOrder, fills_patches_of_a_mesh) {
  for (const Mesh& mesh : {grid_cloth(60, 60, 0.1), icosphere(4, 1.0), torus(1.0, 0.3, 60, 30)}) {
    const std::size_t least = (mesh.triangles.size() + kPatchSize - 1) / kPatchSize;
    EXPECT_LE(patch_count(patches_of(mesh)), least + least / 8);
  }
}

// The order of the triangles does not matter.
TEST(PatchOrder, has_triangles_of_a_patch_near_each_other) {
  Mesh mesh = grid_cloth(50, 50, 1.0);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    std::swap(mesh.triangles[i], mesh.triangles[i * 7919 % mesh.triangles.size()]);
  }
  const PatchOrder patches = patches_of(mesh);
  std::size_t wide = 0;
  for (std::size_t patch = 0; patch < patch_count(patches); ++patch) {
    Vec3d lo = mesh.positions[mesh.triangles[patches.triangles[kPatchSize * patch]].v[0]];
    Vec3d hi = lo;
    for (std::size_t i = 0; i < kPatchSize; ++i) {
      const std::uint32_t t = patches.triangles[kPatchSize * patch + i];
      if (t == kNoIndex) continue;
      for (const std::uint32_t v : mesh.triangles[t].v) {
        const Vec3d& p = mesh.positions[v];
        lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), 0.0};
        hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), 0.0};
      }
    }
    wide += hi.x - lo.x + hi.y - lo.y > 7.0 ? 1 : 0;
  }
  EXPECT_LT(wide, patch_count(patches) / 50);
}

}  // namespace
}  // namespace softcd::test

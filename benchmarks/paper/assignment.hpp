#pragma once

#include <cstdint>

#include "paper/control_bits.hpp"
#include "softcd/math/sphere.hpp"
#include "softcd/stages/cell_assignment.hpp"

/// The paper's own assignment of triangles to cells (sections 3.1 to 3.3):
/// - Spheres have a radius of at most a third of the cell, so that each overlaps at most eight cells.
/// - Home cells and control bits are given by parity types.
/// - Each (cell, root) has one representative child, which is at home there if any child is.
/// - Fast triangles halve their own step instead of the step of all triangles.
namespace softcd::paper {

/// A triangle that is represented in the grid by children: 4^level in space, times 2^halvings in time.
struct Split {
  std::uint32_t root;
  std::uint16_t level;
  std::uint16_t halvings;

  SOFTCD_HD constexpr std::uint32_t child_count() const { return 1U << (2 * level + halvings); }
};

/// A cell in which a child of a split triangle is registered. Several children may give the same cell.
struct SplitCell {
  std::uint64_t key;    ///< place among the split triangles:32 | cell:27 from high to low
  std::uint32_t child;  ///< child | 2^31 where its centre lies in another cell, so that the smallest value is the best
};

constexpr std::uint32_t kPhantomChild = 0x80000000U;

SOFTCD_HD constexpr std::uint64_t split_key(std::uint32_t split, std::uint32_t cell) {
  return (static_cast<std::uint64_t>(split) << (kCellBits)) | cell;
}
SOFTCD_HD constexpr std::uint32_t split_key_cell(std::uint64_t key) {
  return static_cast<std::uint32_t>(key & ((1ULL << (kCellBits)) - 1ULL));
}
SOFTCD_HD constexpr std::uint32_t split_key_split(std::uint64_t key) {
  return static_cast<std::uint32_t>(key >> (kCellBits));
}

/// Split cells as a structure of arrays, so that only keys and values of the sort move.
struct SplitCellTarget {
  using Value = SplitCell;
  std::uint64_t* keys;
  std::uint32_t* children;
  SOFTCD_HD void store(std::uint64_t i, const SplitCell& value) const {
    keys[i] = value.key;
    children[i] = value.child;
  }
};

SOFTCD_HD inline bool sphere_meets_cell(const Sphere& sphere, Cell cell, float size) {
  const float lo[3] = {static_cast<float>(cell.x) * size, static_cast<float>(cell.y) * size,
                       static_cast<float>(cell.z) * size};
  float squared_distance = 0.0F;
  for (int axis = 0; axis < 3; ++axis) {
    const float centre = sphere.centre[axis];
    const float gap = larger(larger(lo[axis] - centre, centre - (lo[axis] + size)), 0.0F);
    squared_distance += gap * gap;
  }
  return squared_distance <= sphere.radius * sphere.radius;
}

/// Calls visit(cell) for every cell that the sphere overlaps.
template <class Visit>
SOFTCD_HD void for_each_cell(const Sphere& sphere, const GridParameters& grid, Visit visit) {
  const Vec3f radii = {sphere.radius, sphere.radius, sphere.radius};
  const Cell lo = cell_of(sphere.centre - radii, grid.inverse_cell_size);
  const Cell hi = cell_of(sphere.centre + radii, grid.inverse_cell_size);
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        if (sphere_meets_cell(sphere, Cell{x, y, z}, grid.cell_size)) visit(Cell{x, y, z});
      }
    }
  }
}

SOFTCD_HD inline std::uint32_t touched_types(const Sphere& sphere, const GridParameters& grid) {
  std::uint32_t types = 0;
  for_each_cell(sphere, grid, [&](Cell cell) { types |= 1U << Control::type_of(Control::cell_index(cell)); });
  return types;
}

/// Calls visit(sibling) for the other three children of the same parent, in the same part of the step. A parent in row
/// R splits into rows 2 R and 2 R + 1. Row 2 R has one child of an upright parent and three of an inverted one; row 2 R
/// + 1 the reverse.
template <class Visit>
SOFTCD_HD void for_each_sibling(Split root, std::uint32_t child, Visit visit) {
  if (root.level == 0) return;
  const ChildPlace place = child_place(child >> root.halvings);
  const std::uint32_t slab = child & ((1U << root.halvings) - 1U);
  const std::uint32_t even_row = place.row & ~1U;
  const std::uint32_t group = place.place & ~3U;
  const bool is_upright = place.row == even_row ? place.place == group : place.place != group + 3;
  const std::uint32_t family[4][2] = {{even_row, is_upright ? group : group + 1},
                                      {even_row + (is_upright ? 1 : 0), is_upright ? group : group + 2},
                                      {even_row + (is_upright ? 1 : 0), is_upright ? group + 1 : group + 3},
                                      {even_row + 1, is_upright ? group + 2 : group + 3}};
  for (const std::uint32_t(&member)[2] : family) {
    const std::uint32_t sibling = ((member[0] * member[0] + member[1]) << root.halvings) | slab;
    if (sibling != child) visit(sibling);
  }
}

/// Returns the sphere around one child in its part of the step.
SOFTCD_HD inline Sphere child_sphere(const SceneView& scene, Split root, std::uint32_t child, float growth) {
  const TriangleMotion parent = load_triangle(scene, root.root);
  const TriangleMotion motion = child_motion(parent, root.level, child >> root.halvings);
  const std::uint32_t slab = child & ((1U << root.halvings) - 1U);
  const float width = 1.0F / static_cast<float>(1U << root.halvings);
  Box box = box_of(lerp(motion.t0[0], motion.t1[0], width * static_cast<float>(slab)));
  for (int corner = 0; corner < 3; ++corner) {
    box = merged(box, box_of(lerp(motion.t0[corner], motion.t1[corner], width * static_cast<float>(slab))));
    box = merged(box, box_of(lerp(motion.t0[corner], motion.t1[corner], width * static_cast<float>(slab + 1))));
  }
  const Sphere sphere = bounding_sphere(box.lo, box.hi, box.lo);
  return {sphere.centre, outward_up(sphere.radius + growth)};
}

/// Registers triangles with a small enough sphere, and lists the others. A triangle whose margin alone is too large
/// stays whole.
struct RegisterTriangle {
  SceneView scene;
  const Kdop18* volumes;
  TriangleShape* shapes;
  const GridParameters* grid;
  bool subdivision;

  template <class Entries, class Splits, class Bigs>
  SOFTCD_HD void operator()(std::uint32_t t, Entries& entries, Splits& splits, Bigs& bigs) const {
    if (is_empty(volumes[t])) return;
    if (!within_grid(volumes[t], grid->inverse_cell_size)) {
      list_big(t, bigs);
      return;
    }
    const TriangleShape shape = shapes[t];
    Split split = {t, 0, 0};
    const Sphere sphere = child_sphere(scene, split, 0, shape.growth);
    const float third = grid->cell_size / 3.0F;
    if (subdivision && shape.growth <= third) {
      const float limit = larger(third - shape.growth, 0.5F * third);
      float radius = shape.radius;
      float sweep = larger(sphere.radius - shape.growth - radius, 0.0F);
      while (!(radius + sweep <= limit) && split.level <= kMaxLevel && split.halvings <= kMaxLevel) {
        if (radius >= sweep) {
          radius *= 0.5F;
          ++split.level;
        } else {
          sweep *= 0.5F;
          ++split.halvings;
        }
      }
    }
    if (split.level > kMaxLevel || split.halvings > kMaxLevel) {
      list_big(t, bigs);
    } else if (split.level > 0 || split.halvings > 0) {
      splits.push(split);
    } else {
      const std::uint32_t home = Control::type_of(Control::cell_index(cell_of(sphere.centre, grid->inverse_cell_size)));
      const std::uint32_t control = Control::pack(home, touched_types(sphere, *grid), 0);
      const std::uint32_t body = scene.triangle_body[t];
      const Entry entry = {t, entry_bits(control, body, wanted_features(shape.flags))};
      const std::uint32_t rank = entry_rank(scene, body, 7);
      for_each_cell(sphere, *grid, [&](Cell cell) {
        entries.push(KeyedEntry{entry_key(Control::cell_index(cell), rank), entry});
      });
    }
  }

 private:
  template <class Bigs>
  SOFTCD_HD void list_big(std::uint32_t t, Bigs& bigs) const {
    shapes[t].flags |= kBigTriangle;
    bigs.push(t);
  }
};

/// Registers the cells of one child, with the child and whether it is at home there.
struct RegisterChild {
  SceneView scene;
  const TriangleShape* shapes;
  const Split* splits;
  const GridParameters* grid;

  template <class Cells>
  SOFTCD_HD void operator()(std::uint32_t split, std::uint32_t child, Cells& cells) const {
    const Split root = splits[split];
    const Sphere sphere = child_sphere(scene, root, child, shapes[root.root].growth);
    const std::uint32_t home = Control::cell_index(cell_of(sphere.centre, grid->inverse_cell_size));
    for_each_cell(sphere, *grid, [&](Cell cell) {
      const std::uint32_t index = Control::cell_index(cell);
      cells.push(SplitCell{split_key(split, index), index == home ? child : child | kPhantomChild});
    });
  }
};

/// Makes one entry for each (cell, root), for its representative, with the siblings' home types.
struct RegisterSplitCell {
  SceneView scene;
  const TriangleShape* shapes;
  const GridParameters* grid;
  const Split* splits;
  const std::uint64_t* keys;
  const std::uint32_t* children;
  Count key_count;

  template <class Entries>
  SOFTCD_HD void operator()(std::uint32_t i, Entries& entries) const {
    const std::uint64_t key = keys[i];
    if (i > 0 && keys[i - 1] == key) return;
    std::uint32_t best = children[i];
    for (std::uint64_t j = i + 1ULL; j < key_count.get() && keys[j] == key; ++j) {
      if (children[j] < best) best = children[j];
    }
    const std::uint32_t representative = best & ~kPhantomChild;
    const std::uint32_t index = split_key_cell(key);
    const Split split = splits[split_key_split(key)];
    const float growth = shapes[split.root].growth;

    std::uint32_t siblings = 0;
    for_each_sibling(split, representative, [&](std::uint32_t sibling) {
      siblings |= 1U << home_type(child_sphere(scene, split, sibling, growth));
    });
    const Sphere sphere = child_sphere(scene, split, representative, growth);
    const std::uint32_t control = Control::pack(home_type(sphere), touched_types(sphere, *grid), siblings);
    const std::uint32_t body = scene.triangle_body[split.root];
    entries.push(KeyedEntry{entry_key(index, entry_rank(scene, body, 7)),
                            {split.root, entry_bits(control, body, wanted_features(shapes[split.root].flags))}});
  }

 private:
  SOFTCD_HD std::uint32_t home_type(const Sphere& sphere) const {
    return Control::type_of(Control::cell_index(cell_of(sphere.centre, grid->inverse_cell_size)));
  }
};

}  // namespace softcd::paper

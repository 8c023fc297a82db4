#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "softcd/core/vec3.hpp"
#include "softcd/softcd.hpp"

namespace softcd::demo {

/// A body as for a pipeline. Positions must be finite.
struct GridBody {
  BodyDesc desc;
  Positions x_t0, x_t1;
};

/// A triangle in a cell. Bits are those of softcd/grid/control_bits.hpp.
struct GridEntry {
  static constexpr std::uint32_t kMaskBits = 13;

  std::uint32_t triangle;  ///< counted over all bodies
  std::uint32_t mask;      ///< the cell's lower neighbours that hold the triangle, too
  std::uint32_t missing;   ///< K: axes along which the lower neighbour does not hold it
};

/// A cell that holds at least one triangle.
struct OccupiedCell {
  std::uint32_t index;  ///< see cell_index
  Vec3d low;            ///< its lowest corner; where cells share an index, that of its first entry
  std::size_t first_entry, entry_count;
  std::uint64_t tests;  ///< pairs of triangles that are tested here
};

/// The grid of triangles in which the detector on a GPU searches for contacts between these bodies. It runs the
/// detector's own stages on the CPU and reads their intermediate results. The CPU's own `exact` grid has patches of
/// triangles in larger cells. For `exact` and `uniform`.
class DetectionGrid {
 public:
  DetectionGrid(const std::vector<GridBody>& bodies, const QueryOptions& options);

  double cell_size() const { return counts_.cell_size; }
  const Statistics& counts() const { return counts_; }

  /// Returns the cells in ascending order of index.
  const std::vector<OccupiedCell>& cells() const { return cells_; }
  /// Returns the cell around a triangle's centroid at t1; null when no triangle is in it.
  const OccupiedCell* cell_around(std::uint32_t triangle) const;
  Span<const GridEntry> entries(const OccupiedCell& cell) const {
    return {entries_.data() + cell.first_entry, cell.entry_count};
  }

  std::uint32_t first_triangle(std::size_t body) const { return first_triangles_[body]; }
  std::size_t body_of(std::uint32_t triangle) const;
  /// Returns the cells in which the triangle is registered.
  std::vector<const OccupiedCell*> cells_of(std::uint32_t triangle) const;

  using Corners = std::array<Vec3d, 3>;
  /// Returns the virtual children that represent the triangle, at t1; empty when it is not split.
  std::vector<Corners> children_of(std::uint32_t triangle) const;

 private:
  struct SplitTriangle {
    std::uint32_t triangle;
    int level;  ///< number of 1-to-4 splits
  };

  Vec3d origin_;
  float inverse_cell_size_ = 0.0F;
  Statistics counts_;
  std::vector<OccupiedCell> cells_;
  std::vector<GridEntry> entries_;  ///< those of a cell lie together
  std::vector<SplitTriangle> splits_;
  std::vector<std::uint32_t> first_triangles_;
  std::vector<Triangle> triangles_;
  std::vector<Vec3f> x_t1_;  ///< relative to origin_
};

}  // namespace softcd::demo

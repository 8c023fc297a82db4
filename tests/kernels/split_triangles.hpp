#pragma once

#include <cstdint>
#include <vector>

#include "host_scene.hpp"
#include "softcd/stages/split_cells.hpp"

namespace softcd::test {

/// Runs the detector's stages for split triangles, one after the other.
inline void register_split_triangles(const SceneView& scene, const Kdop18* volumes, const TriangleShape* shapes,
                                     const std::vector<SplitRoot>& splits, const GridParameters& grid,
                                     Collector<KeyedEntry>& entries) {
  std::vector<SplitBox> boxes(splits.size());
  std::vector<std::uint32_t> counts(splits.size());
  std::vector<std::uint64_t> offsets(splits.size());
  std::uint64_t word_count = 0;
  for (std::uint32_t s = 0; s < splits.size(); ++s) {
    BoundSplit{volumes, splits.data(), &grid, boxes.data(), counts.data()}(s);
    offsets[s] = word_count;
    word_count += counts[s];
  }
  std::vector<std::uint32_t> words(word_count, 0U);
  const SplitBits bits{boxes.data(), offsets.data(), words.data(), word_count};
  for (std::uint32_t s = 0; s < splits.size(); ++s) {
    for (std::uint32_t child = 0; child < splits[s].child_count(); ++child) {
      MarkChild{scene, shapes, splits.data(), &grid, bits}(s, child);
    }
    for (std::uint32_t k = 0; k < counts[s]; ++k) {
      RegisterMarkedCells{scene, shapes, splits.data(), bits, {}}(s, k, entries);
    }
  }
}

}  // namespace softcd::test

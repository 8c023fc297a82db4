#pragma once

#include <algorithm>
#include <cstdint>

#include "softcd/core/count.hpp"
#include "softcd/stages/clear_word.hpp"
#include "softcd/stages/lbvh.hpp"

namespace softcd {

/// A hierarchy over a scene's triangles in a backend's memory, valid while these do not move.
template <class Backend>
class Bvh {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  template <class T>
  using SortBuffer = typename Backend::template SortBuffer<T>;

 public:
  /// Builds the hierarchy, unless it has this revision. Throws what the backend throws; there is no hierarchy then.
  void build(Backend& backend, const BvhInput& input, std::uint64_t revision) {
    if (revision == revision_) return;
    revision_ = 0;
    const std::uint32_t leaf_count = std::max(input.triangle_count, 2U);
    reserve(backend, leaf_count);
    const std::uint64_t counts[] = {leaf_count, leaf_count - 1};
    backend.upload(counts_, Span<const std::uint64_t>(counts, 2));
    const Count leaves = {counts_.data(), leaf_count};
    const Count nodes = {counts_.data() + 1, leaf_count - 1};
    keys_.rewind();
    triangles_.rewind();
    backend.for_each("key_leaf", leaves, KeyLeaf{input, keys_.data(), triangles_.data()});
    backend.sort_pairs("sort_leaves", leaves, keys_, triangles_, kMortonBits);
    backend.for_each("place_leaf", leaves, PlaceLeaf{input, triangles_.data(), leaves_.data()});
    backend.for_each("link_node", nodes, LinkNode{keys_.data(), leaf_count, nodes_.data(), leaf_parents_.data()});
    backend.for_each("clear_arrivals", nodes, ClearWord{arrivals_.data()});
    backend.for_each("fit_boxes", leaves,
                     FitBoxes{leaves_.data(), leaf_parents_.data(), nodes_.data(), arrivals_.data()});
    revision_ = revision;
  }

  BvhView view() const { return {nodes_.data(), leaves_.data()}; }

 private:
  void reserve(Backend& backend, std::uint64_t leaf_count) {
    counts_.reserve(backend, 2, 0);
    keys_.reserve(backend, leaf_count, 0);
    triangles_.reserve(backend, leaf_count, 0);
    leaves_.reserve(backend, leaf_count, 0);
    nodes_.reserve(backend, leaf_count, 0);
    leaf_parents_.reserve(backend, leaf_count, 0);
    arrivals_.reserve(backend, leaf_count, 0);
  }

  Buffer<std::uint64_t> counts_;  ///< leaves, inner nodes
  SortBuffer<std::uint64_t> keys_;
  SortBuffer<std::uint32_t> triangles_;
  Buffer<BvhLeaf> leaves_;
  Buffer<BvhNode> nodes_;
  Buffer<std::uint32_t> leaf_parents_;
  Buffer<std::uint32_t> arrivals_;
  std::uint64_t revision_ = 0;  ///< 0: there is none
};

}  // namespace softcd

#pragma once

#include <cstdint>

#include "softcd/core/bits.hpp"
#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/math/box.hpp"
#include "softcd/mesh/features.hpp"

/// A linear bounding volume hierarchy: triangles in the order of their centres' Morton codes, and the binary radix tree
/// over them. Karras describes it (Maximizing Parallelism in the Construction of BVHs, Octrees, and k-d Trees, 2012).
/// It depends on the triangles alone, not on the backend.
namespace softcd {

/// Bits of a Morton code.
constexpr int kMortonBitsPerAxis = 14;
constexpr int kMortonBits = 3 * kMortonBitsPerAxis;

/// Longest path from the root. Leaves below any node have more of their Morton code, and then of their place, in common
/// than those below its parent.
constexpr int kBvhDepth = kMortonBits + 32;

/// Marks a child that is a leaf.
constexpr std::uint32_t kLeafBit = 0x80000000u;

/// A set of bodies: bit i stands for those whose number is i modulo kBvhBodyClasses.
using BodyClasses = std::uint16_t;
constexpr std::uint32_t kBvhBodyClasses = 16;
constexpr BodyClasses kAllBodies = 0xFFFFu;

SOFTCD_HD constexpr BodyClasses class_of(std::uint32_t body) {
  return static_cast<BodyClasses>(1U << (body % kBvhBodyClasses));
}

/// Returns a box that overlaps nothing.
SOFTCD_HD constexpr Box empty_box() {
  constexpr float kMost = 3.402823466e38F;
  return {{kMost, kMost, kMost}, {-kMost, -kMost, -kMost}};
}

/// A node of the tree. Node 0 is the root.
struct alignas(16) BvhNode {
  Box boxes[2];               ///< of its children
  std::uint32_t children[2];  ///< nodes, or kLeafBit | leaf
  std::uint32_t parent;       ///< 2 * node that it is a child of + which child; kNoIndex for the root
  BodyClasses bodies[2];      ///< below its children
};

/// A triangle with its positions.
struct alignas(16) BvhLeaf {
  Vec3f x[3];
  std::uint32_t triangle;  ///< of the scene; kNoIndex: none
  std::uint32_t body;
  std::uint32_t unused;
};

/// A hierarchy of at least two leaves.
struct BvhView {
  const BvhNode* nodes;
  const BvhLeaf* leaves;
};

/// Input of a hierarchy; see SceneView.
struct BvhInput {
  const Vec3f* x;
  const Triangle* triangles;
  const Ownership* ownership;
  const std::uint32_t* triangle_body;
  std::uint32_t triangle_count;
  Box bounds;  ///< of all triangles

  /// Whether leaf i has a triangle: there are leaves beyond the triangles, and triangles that are left out.
  SOFTCD_HD bool has_triangle(std::uint32_t i) const { return i < triangle_count && (ownership[i] & kLeftOut) == 0U; }
};

SOFTCD_HD inline Box box_of(const Vec3f (&x)[3]) {
  return merged(merged(box_of(x[0]), box_of(x[1])), box_of(x[2]));
}

/// Spreads the bits to every third one, from the lowest on.
SOFTCD_HD constexpr std::uint64_t spread_bits(std::uint64_t bits) {
  bits = (bits | (bits << 32)) & 0x001F00000000FFFFULL;
  bits = (bits | (bits << 16)) & 0x001F0000FF0000FFULL;
  bits = (bits | (bits << 8)) & 0x100F00F00F00F00FULL;
  bits = (bits | (bits << 4)) & 0x10C30C30C30C30C3ULL;
  return (bits | (bits << 2)) & 0x1249249249249249ULL;
}

/// Makes the leaves' sort keys. Leaves without a triangle come last.
struct KeyLeaf {
  BvhInput input;
  std::uint64_t* keys;
  std::uint32_t* triangles;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    triangles[i] = i;
    keys[i] = (1ULL << kMortonBits) - 1;
    if (!input.has_triangle(i)) return;
    const Triangle triangle = input.triangles[i];
    const Vec3f x[3] = {input.x[triangle.v[0]], input.x[triangle.v[1]], input.x[triangle.v[2]]};
    const Box box = box_of(x);
    const Vec3f centre = 0.5F * box.lo + 0.5F * box.hi;
    keys[i] = spread_bits(cell(centre, 0)) | (spread_bits(cell(centre, 1)) << 1) | (spread_bits(cell(centre, 2)) << 2);
  }

 private:
  SOFTCD_HD std::uint64_t cell(Vec3f centre, int axis) const {
    constexpr float kCells = 1 << kMortonBitsPerAxis;
    const float lo = input.bounds.lo[axis];
    const float width = input.bounds.hi[axis] - lo;
    const float place = width > 0.0F ? (centre[axis] - lo) / width * kCells : 0.0F;
    return static_cast<std::uint64_t>(smaller(larger(place, 0.0F), kCells - 1.0F));
  }
};

/// Writes the leaves in order.
struct PlaceLeaf {
  BvhInput input;
  const std::uint32_t* triangles;
  BvhLeaf* leaves;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    BvhLeaf leaf{};
    leaf.triangle = kNoIndex;
    const std::uint32_t t = triangles[i];
    if (input.has_triangle(t)) {
      const Triangle triangle = input.triangles[t];
      for (int corner = 0; corner < 3; ++corner) leaf.x[corner] = input.x[triangle.v[corner]];
      leaf.triangle = t;
      leaf.body = input.triangle_body[t];
    }
    leaves[i] = leaf;
  }
};

/// Links inner node i to its children. The node has the leaves that share the most with leaf i, on the side of i that
/// shares more.
struct LinkNode {
  const std::uint64_t* keys;
  std::uint32_t leaf_count;
  BvhNode* nodes;
  std::uint32_t* leaf_parents;  ///< as BvhNode::parent

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const auto first = static_cast<std::int64_t>(i);
    const std::int64_t step = common_prefix(first, first + 1) > common_prefix(first, first - 1) ? 1 : -1;
    const std::int64_t last = first + step * length(first, step);
    const std::int64_t split = split_of(first, last);
    const std::int64_t low = first < last ? first : last;
    const std::int64_t high = first < last ? last : first;
    link(i, 0, split, split == low);
    link(i, 1, split + 1, split + 1 == high);
    if (i == 0) nodes[0].parent = kNoIndex;
  }

 private:
  /// Returns the number of bits that the keys have in common; places count for equal keys. -1 if there is no leaf j.
  SOFTCD_HD int common_prefix(std::int64_t i, std::int64_t j) const {
    if (j < 0 || j >= static_cast<std::int64_t>(leaf_count)) return -1;
    const std::uint64_t difference = keys[i] ^ keys[j];
    return difference != 0 ? leading_zeros(difference) : 64 + leading_zeros(static_cast<std::uint64_t>(i ^ j));
  }

  /// Returns the number of leaves that the node has beyond the first.
  SOFTCD_HD std::int64_t length(std::int64_t first, std::int64_t step) const {
    const int least = common_prefix(first, first - step);
    std::int64_t bound = 2;
    while (common_prefix(first, first + bound * step) > least) bound *= 2;
    std::int64_t length = 0;
    for (std::int64_t part = bound / 2; part > 0; part /= 2) {
      if (common_prefix(first, first + (length + part) * step) > least) length += part;
    }
    return length;
  }

  /// Returns the last leaf of the first child.
  SOFTCD_HD std::int64_t split_of(std::int64_t first, std::int64_t last) const {
    const int common = common_prefix(first, last);
    const std::int64_t step = first < last ? 1 : -1;
    const std::int64_t length = (last - first) * step;
    std::int64_t beyond = 0;
    for (std::int64_t part = length; part > 1;) {
      part = (part + 1) / 2;
      if (common_prefix(first, first + (beyond + part) * step) > common) beyond += part;
    }
    return first + beyond * step + (step < 0 ? -1 : 0);
  }

  SOFTCD_HD void link(std::uint32_t node, std::uint32_t side, std::int64_t child, bool is_leaf) const {
    const auto index = static_cast<std::uint32_t>(child);
    nodes[node].children[side] = is_leaf ? kLeafBit | index : index;
    (is_leaf ? leaf_parents[index] : nodes[index].parent) = 2 * node + side;
  }
};

/// Whether the other child's box is there, too: the second of two that arrive sees what the first has written.
SOFTCD_HD inline bool arrives_second(std::uint32_t* arrivals) {
#if defined(__CUDA_ARCH__)
  __threadfence();
  const bool is_second = atomicAdd(arrivals, 1U) == 1U;
  __threadfence();
  return is_second;
#else
  return __atomic_fetch_add(arrivals, 1U, __ATOMIC_ACQ_REL) == 1U;
#endif
}

/// Fits boxes and bodies from leaf i upwards, as far as the other children's are known.
struct FitBoxes {
  const BvhLeaf* leaves;
  const std::uint32_t* leaf_parents;
  BvhNode* nodes;
  std::uint32_t* arrivals;  ///< per node, 0 before

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const bool is_empty = leaves[i].triangle == kNoIndex;
    Box box = is_empty ? empty_box() : box_of(leaves[i].x);
    BodyClasses bodies = is_empty ? BodyClasses{0} : class_of(leaves[i].body);
    std::uint32_t parent = leaf_parents[i];
    while (parent != kNoIndex) {
      BvhNode& node = nodes[parent / 2];
      node.boxes[parent % 2] = box;
      node.bodies[parent % 2] = bodies;
      if (!arrives_second(arrivals + parent / 2)) return;
      box = merged(node.boxes[0], node.boxes[1]);
      bodies = static_cast<BodyClasses>(node.bodies[0] | node.bodies[1]);
      parent = node.parent;
    }
  }
};

/// Calls visitor.visit(leaf, place) for the leaves that visitor.enters(box, key) leads to, those with lower keys first,
/// as long as visitor.still_enters(key). Skips nodes without any of these bodies.
template <class Visitor>
SOFTCD_HD void visit_leaves(const BvhView& bvh, Visitor& visitor, BodyClasses bodies = kAllBodies) {
  using Key = typename Visitor::Key;
  struct Waiting {
    Key key;
    std::uint32_t child;
  };
  // One of two children waits at each node of the path.
  Waiting waiting[kBvhDepth];
  int count = 0;
  std::uint32_t current = 0;
  while (true) {
    if ((current & kLeafBit) != 0U) {
      visitor.visit(bvh.leaves[current & ~kLeafBit], current & ~kLeafBit);
    } else {
      const BvhNode& node = bvh.nodes[current];
      Key keys[2];
      const bool enters_first = (node.bodies[0] & bodies) != 0 && visitor.enters(node.boxes[0], keys[0]);
      const bool enters_second = (node.bodies[1] & bodies) != 0 && visitor.enters(node.boxes[1], keys[1]);
      if (enters_first || enters_second) {
        const int next = enters_first && (!enters_second || keys[0] <= keys[1]) ? 0 : 1;
        if (enters_first && enters_second) waiting[count++] = {keys[1 - next], node.children[1 - next]};
        current = node.children[next];
        continue;
      }
    }
    do {
      if (count == 0) return;
      --count;
    } while (!visitor.still_enters(waiting[count].key));
    current = waiting[count].child;
  }
}

}  // namespace softcd

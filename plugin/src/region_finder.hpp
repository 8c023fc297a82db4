#pragma once

#include <map>
#include <tuple>
#include <vector>

#include "box_pairs.hpp"
#include "intersection_curves.hpp"
#include "softcd/intersection_regions.hpp"

namespace softcd::detail {

/// A region before its vertices have a way out.
struct FoundRegion {
  std::uint32_t surface = 0, other = 0;  ///< numbers of bodies
  RegionKind kind = RegionKind::closed;
  bool is_inside = false;
  std::vector<std::uint32_t> vertices, triangles, curves;  ///< ascending, each once
  /// Triangles of the surface along the curves' other traces, where a body intersects itself.
  std::vector<std::uint32_t> opposite;
  double area = 0;
};

/// A surface, and the other one, or itself, that it may intersect: numbers of bodies.
struct SurfacePair {
  std::uint32_t surface, other;

  friend bool operator==(const SurfacePair&, const SurfacePair&) = default;
  friend bool operator<(const SurfacePair& a, const SurfacePair& b) {
    return std::tie(a.surface, a.other) < std::tie(b.surface, b.other);
  }
};

/// The connected parts of surfaces, kept as long as no mesh changes.
class SurfaceParts {
 public:
  /// Forgets all parts if the revision of the meshes is another one than at the last call.
  void follow(std::uint64_t revision);
  /// Returns the pairs that may have regions without a curve: a part of the first surface is within the box of the
  /// second, which is closed. Ascending.
  std::vector<SurfacePair> pairs_within_boxes(Span<const Surface> surfaces, const ProbeBodies& asked);

 private:
  /// The part of each vertex; numbered in the order of their first vertices, kNoIndex without a triangle.
  using PartOfVertex = std::vector<std::uint32_t>;
  const PartOfVertex& parts_of(const Surface& surface);

  BoxPairs box_pairs_;
  std::uint64_t revision_ = 0;
  std::map<std::uint32_t, PartOfVertex> parts_;  ///< by ids of bodies
};

/// Finds all regions, by surface, other surface and lowest triangle. `without_curves` are pairs that may have regions
/// without a curve, ascending.
std::vector<FoundRegion> find_regions(Span<const Surface> surfaces, const IntersectionCurves& found,
                                      Span<const SurfacePair> without_curves);

/// Returns the point of a node on its edge, relative to the scene's origin.
Vec3d point_of(const CurveNode& node, Span<const Surface> surfaces);

/// A vertex's part of the gradient of a curve's length.
struct LengthGradient {
  std::uint32_t surface, vertex;
  Vec3d gradient;
};

/// Returns the gradient of a curve's length for the vertices of its edges and triangles, each once, ascending.
std::vector<LengthGradient> length_gradient(const Curve& curve, const IntersectionCurves& found,
                                            Span<const Surface> surfaces);

double length_of(const Curve& curve, const IntersectionCurves& found, Span<const Surface> surfaces);

}  // namespace softcd::detail

#pragma once

#include <vector>

#include "region_finder.hpp"
#include "scene_store.hpp"
#include "softcd/stages/probed_scene.hpp"

namespace softcd::detail {

/// A question about regions. The references are the probe's.
struct RegionQuestion {
  Span<const ProbedBody> bodies;  ///< all of the scene's
  ProbeBodies pair;
  bool at_t0;

  /// Returns whether an answer without intersecting triangles may need positions: a body may be inside a closed one.
  bool may_be_inside() const;
};

/// The intersection regions of a scene, and memory for them. Owned by ProbeCore.
class RegionReport {
 public:
  /// Points for which the nearest ones of another body are needed.
  struct Search {
    BodyId other;
    std::vector<ProbePoint> points;
    std::vector<std::uint32_t> vertices;  ///< indices among the report's vertices
  };

  /// Finds curves and regions from the intersecting pairs. The scene must be up to date, with positions on the host.
  void find(const SceneStore& scene, const RegionQuestion& question, Span<const TriangleIntersection> pairs);
  /// Makes the report empty.
  void clear();
  /// Returns the searches that the last find() needs; each must be passed to lead_to() with its results.
  const std::vector<Search>& searches() const { return searches_; }
  /// Sets the ways out to the triangles that are closest to a search's points. Scene and pair are those of find().
  void lead_to(const SceneStore& scene, const RegionQuestion& question, const Search& search,
               Span<const ClosestPoint> closest);
  IntersectionRegions view() const;

 private:
  void list_curves(const IntersectionCurves& found, Span<const Surface> surfaces, Vec3d origin);
  void list_regions(Span<const FoundRegion> found, Span<const Surface> surfaces);
  void lead_out(Span<const FoundRegion> found, const IntersectionCurves& curves, Span<const Surface> surfaces,
                Vec3d origin);
  void lead_to_opposite(std::size_t index, Span<const FoundRegion> found, const Surface& surface);
  void shorten_curves(std::size_t index, const FoundRegion& found, const IntersectionCurves& curves,
                      Span<const Surface> surfaces);
  Search& search_for(BodyId other);

  std::vector<IntersectionRegion> regions_;
  std::vector<RegionVertex> vertices_;
  std::vector<std::uint32_t> triangles_, region_curves_;
  std::vector<IntersectionCurve> curves_;
  std::vector<CurvePoint> points_;
  std::vector<Search> searches_;
  SurfaceParts parts_;
  std::uint64_t touching_pairs_ = 0;
};

}  // namespace softcd::detail

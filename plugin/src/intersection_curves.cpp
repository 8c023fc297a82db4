#include "intersection_curves.hpp"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

namespace softcd::detail {
namespace {

/// The part of a curve within two triangles: from one node to another.
struct CurveSegment {
  SurfaceTriangle triangles[2];
  CurveNode ends[2];
  std::uint32_t nodes[2] = {0, 0};  ///< indices of the ends among all nodes
};

std::uint32_t number_of_surface(BodyId id, Span<const Surface> surfaces) {
  const auto at = std::lower_bound(surfaces.begin(), surfaces.end(), id, [](const Surface& surface, BodyId wanted) {
    return surface.id.value < wanted.value;
  });
  return static_cast<std::uint32_t>(at - surfaces.begin());
}

/// Finds the nodes of one pair of triangles.
class SegmentOfPair {
 public:
  SegmentOfPair(Span<const Surface> surfaces, const SurfaceTriangle& a, const SurfaceTriangle& b) {
    const Triangle at_a = surfaces[a.surface].triangle(a.triangle);
    const Triangle at_b = surfaces[b.surface].triangle(b.triangle);
    const SharedCorners shared = a.surface == b.surface ? shared_corners(at_a, at_b) : SharedCorners{};
    segment_.triangles[0] = a;
    segment_.triangles[1] = b;
    add_sides(surfaces[a.surface], at_a, shared.of_a, surfaces[b.surface], at_b, b);
    add_sides(surfaces[b.surface], at_b, shared.of_b, surfaces[a.surface], at_a, a);
    if (count_ == 1) {
      // The curve begins at the vertex that both have.
      for (std::uint32_t i = 0; i < 3; ++i) {
        if (((shared.of_a >> i) & 1U) == 0) continue;
        segment_.ends[count_++] = {{a.surface, {at_a.v[i], at_a.v[i]}}, std::max(a, b), 0, false};
        break;
      }
    }
  }

  bool exists() const { return count_ == 2; }
  const CurveSegment& segment() const { return segment_; }

 private:
  void add_sides(const Surface& surface, const Triangle& triangle, std::uint32_t shared, const Surface& other,
                 const Triangle& through, const SurfaceTriangle& name) {
    PerturbedPoint corners[3];
    for (int i = 0; i < 3; ++i) corners[i] = other.point(through.v[i]);
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t next = (i + 1) % 3;
      if ((((shared >> i) | (shared >> next)) & 1U) != 0) continue;
      const auto [low, high] = std::minmax(triangle.v[i], triangle.v[next]);
      const Passage found = passage(surface.point(low), surface.point(high), corners);
      if (!found.passes || count_ == 2) continue;
      segment_.ends[count_++] = {
          {surface.number, {low, high}}, name, static_cast<std::int8_t>(found.side_of_start), found.is_perturbed};
    }
  }

  CurveSegment segment_{};
  int count_ = 0;
};

/// Joins segments at their nodes.
class CurveWalk {
 public:
  CurveWalk(IntersectionCurves& found, Span<const CurveSegment> segments)
      : found_(found), segments_(segments), first_(found.nodes.size() + 1, 0), is_used_(segments.size(), false) {
    for (const CurveSegment& segment : segments) {
      for (const std::uint32_t node : segment.nodes) ++first_[node + 1];
    }
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    at_node_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t s = 0; s < segments.size(); ++s) {
      for (const std::uint32_t node : segments[s].nodes) at_node_[next[node]++] = s;
    }
  }

  void find_all() {
    for (const bool may_be_inner : {false, true}) {
      for (std::uint32_t node = 0; node < found_.nodes.size(); ++node) {
        if (!may_be_inner && degree(node) == 2) continue;
        for (std::uint32_t i = first_[node]; i < first_[node + 1]; ++i) {
          if (!is_used_[at_node_[i]]) walk(node, at_node_[i]);
        }
      }
    }
  }

 private:
  std::uint32_t degree(std::uint32_t node) const { return first_[node + 1] - first_[node]; }

  /// Follows a curve from a node along a segment. `lines[i]` is the trace on which the segment's triangle i lies.
  void walk(std::uint32_t start, std::uint32_t segment) {
    Curve curve;
    curve.surface_a = segments_[segment].triangles[0].surface;
    curve.surface_b = segments_[segment].triangles[1].surface;
    curve.traces[0].surface = curve.surface_a;
    curve.traces[1].surface = curve.surface_b;
    std::array<std::uint32_t, 2> lines{0, 1};
    std::uint32_t node = start;
    add_node(curve, node, segment, lines);
    while (true) {
      is_used_[segment] = true;
      const CurveSegment& within = segments_[segment];
      for (std::size_t i = 0; i < 2; ++i) curve.traces[lines[i]].triangles.push_back(within.triangles[i].triangle);
      node = within.nodes[0] == node ? within.nodes[1] : within.nodes[0];
      if (node == start) break;
      add_node(curve, node, segment, lines);
      if (degree(node) != 2) break;
      const std::uint32_t first = at_node_[first_[node]];
      const std::uint32_t next = first == segment ? at_node_[first_[node] + 1] : first;
      // The pierced triangle stays on its trace.
      const SurfaceTriangle& pierced = found_.nodes[node].triangle;
      const std::uint32_t line = lines[within.triangles[0] == pierced ? 0 : 1];
      const std::uint32_t place = segments_[next].triangles[0] == pierced ? 0 : 1;
      lines[place] = line;
      lines[1 - place] = 1 - line;
      segment = next;
    }
    curve.is_closed = node == start && degree(start) == 2;
    curve.is_branched = degree(start) > 2 || degree(node) > 2;
    found_.curves.push_back(std::move(curve));
  }

  void add_node(Curve& curve, std::uint32_t index, std::uint32_t segment, const std::array<std::uint32_t, 2>& lines) {
    const CurveNode& node = found_.nodes[index];
    curve.nodes.push_back(index);
    curve.is_perturbed |= node.is_perturbed;
    if (node.is_vertex()) return;
    const std::uint32_t pierced_line = lines[segments_[segment].triangles[0] == node.triangle ? 0 : 1];
    Trace& crossing = curve.traces[1 - pierced_line];
    crossing.nodes.push_back(index);
    if (degree(index) != 1) return;
    crossing.ends_at_border = true;
    curve.traces[pierced_line].ends_within = true;
  }

  IntersectionCurves& found_;
  Span<const CurveSegment> segments_;
  std::vector<std::uint32_t> first_;    ///< index in at_node_ for each node, and the end
  std::vector<std::uint32_t> at_node_;  ///< segments at each node
  std::vector<bool> is_used_;
};

}  // namespace

Passage passage(const PerturbedPoint& p, const PerturbedPoint& q, const PerturbedPoint (&t)[3]) {
  const PerturbedSide p_side = perturbed_side(t[0], t[1], t[2], p);
  const PerturbedSide q_side = perturbed_side(t[0], t[1], t[2], q);
  if (p_side.side == q_side.side) return {};
  const PerturbedSide first = perturbed_side(p, q, t[0], t[1]);
  const PerturbedSide second = perturbed_side(p, q, t[1], t[2]);
  if (first.side != second.side) return {};
  const PerturbedSide third = perturbed_side(p, q, t[2], t[0]);
  if (first.side != third.side) return {};
  return {
      true, p_side.side,
      p_side.is_perturbed || q_side.is_perturbed || first.is_perturbed || second.is_perturbed || third.is_perturbed};
}

IntersectionCurves trace_curves(Span<const Surface> surfaces, Span<const TriangleIntersection> pairs) {
  IntersectionCurves found;
  std::vector<CurveSegment> segments;
  for (const TriangleIntersection& pair : pairs) {
    SurfaceTriangle a = {number_of_surface(pair.body_a, surfaces), pair.triangle_a};
    SurfaceTriangle b = {number_of_surface(pair.body_b, surfaces), pair.triangle_b};
    if (b < a) std::swap(a, b);
    if (!surfaces[a.surface].has_face(a.triangle) || !surfaces[b.surface].has_face(b.triangle)) continue;
    const SegmentOfPair between(surfaces, a, b);
    if (between.exists()) {
      segments.push_back(between.segment());
    } else {
      ++found.touching_pairs;
    }
  }
  const auto by_triangles = [](const CurveSegment& a, const CurveSegment& b) {
    return std::pair(a.triangles[0], a.triangles[1]) < std::pair(b.triangles[0], b.triangles[1]);
  };
  std::sort(segments.begin(), segments.end(), by_triangles);
  for (const CurveSegment& segment : segments) {
    for (const CurveNode& end : segment.ends) {
      if (!end.is_vertex()) found.nodes.push_back(end);
    }
  }
  std::sort(found.nodes.begin(), found.nodes.end());
  found.nodes.erase(std::unique(found.nodes.begin(), found.nodes.end()), found.nodes.end());
  const std::size_t crossings = found.nodes.size();
  for (CurveSegment& segment : segments) {
    for (int i = 0; i < 2; ++i) {
      if (segment.ends[i].is_vertex()) {
        // Each curve that ends at a vertex has an end of its own.
        segment.nodes[i] = static_cast<std::uint32_t>(found.nodes.size());
        found.nodes.push_back(segment.ends[i]);
        continue;
      }
      const auto at = std::lower_bound(found.nodes.begin(),
                                       found.nodes.begin() + static_cast<std::ptrdiff_t>(crossings), segment.ends[i]);
      segment.nodes[i] = static_cast<std::uint32_t>(at - found.nodes.begin());
    }
  }
  CurveWalk(found, segments).find_all();
  const auto key = [](const Curve& curve) {
    return std::tuple(curve.surface_a, curve.surface_b, *std::min_element(curve.nodes.begin(), curve.nodes.end()),
                      curve.nodes.front(), curve.nodes.back());
  };
  std::stable_sort(found.curves.begin(), found.curves.end(),
                   [&](const Curve& a, const Curve& b) { return key(a) < key(b); });
  return found;
}

}  // namespace softcd::detail

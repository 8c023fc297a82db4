#include "region_report.hpp"

#include <algorithm>
#include <cmath>

#include "body_questions.hpp"
#include "curve_length.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::detail {
namespace {

void set_way_out(RegionVertex& vertex, Vec3d offset) {
  const double distance = std::sqrt(squared_norm(offset));
  vertex.distance = distance;
  vertex.direction = distance > 0 ? (1.0 / distance) * offset : Vec3d{0, 0, 0};
}

/// Reads the surfaces of a scene: the given positions if floats round some of them, else the floats.
class SurfaceReader {
 public:
  SurfaceReader(const SceneStore& scene, const RegionQuestion& question) : scene_(scene), bodies_(question.bodies) {
    const SceneArrays arrays = scene.arrays();
    x_ = question.at_t0 ? arrays.x_t0 : arrays.x_t1;
    if (scene.positions().are_rounded_at(question.at_t0)) given_ = question.at_t0 ? arrays.full_t0 : arrays.full_t1;
  }

  /// Returns the point that the surfaces' positions are relative to.
  Vec3d origin() const { return given_.empty() ? scene_.positions().origin() : Vec3d{0, 0, 0}; }

  Surface surface(std::uint32_t number) const {
    const ProbedBody& body = bodies_[number];
    Surface surface;
    surface.id = BodyId{body.id};
    surface.number = number;
    if (!body.is_asked) return surface;
    const Body& stored = scene_.bodies()[number];
    surface.mesh = scene_.layout().mesh_of(stored);
    surface.ownership = scene_.layout().ownership_of(stored);
    surface.x = {x_.data() + body.first_vertex, body.vertex_count};
    if (!given_.empty()) surface.given = {given_.data() + body.first_vertex, body.vertex_count};
    surface.is_closed = body.is_closed;
    return surface;
  }

  std::vector<Surface> all() const {
    std::vector<Surface> surfaces;
    for (std::uint32_t number = 0; number < bodies_.size(); ++number) surfaces.push_back(surface(number));
    return surfaces;
  }

 private:
  const SceneStore& scene_;
  Span<const ProbedBody> bodies_;
  Span<const Vec3f> x_;
  Span<const Vec3d> given_;  ///< empty if all floats are exact
};

/// Returns the way from a point to the nearest point of a triangle.
Vec3d offset_to(Vec3d x, const Surface& surface, const Triangle& triangle) {
  const ClosestPoints<double> closest = closest_points_vertex_triangle(
      x, surface.position(triangle.v[0]), surface.position(triangle.v[1]), surface.position(triangle.v[2]));
  return (-1.0 / closest.scale) * closest.offset;
}

}  // namespace

bool RegionQuestion::may_be_inside() const {
  std::size_t asked = 0;
  bool has_closed = false;
  for (const ProbedBody& body : bodies) {
    asked += body.is_asked ? 1 : 0;
    has_closed |= body.is_asked && body.is_closed;
  }
  return asked > 1 && has_closed && (pair.a != pair.b || pair.a == BodyId());
}

void RegionReport::clear() {
  regions_.clear();
  vertices_.clear();
  triangles_.clear();
  region_curves_.clear();
  curves_.clear();
  points_.clear();
  searches_.clear();
  touching_pairs_ = 0;
}

void RegionReport::find(const SceneStore& scene, const RegionQuestion& question,
                        Span<const TriangleIntersection> pairs) {
  clear();
  const SurfaceReader reader(scene, question);
  const std::vector<Surface> surfaces = reader.all();
  const IntersectionCurves curves = trace_curves(surfaces, pairs);
  parts_.follow(scene.layout().revision());
  const std::vector<SurfacePair> inside =
      question.may_be_inside() ? parts_.pairs_within_boxes(surfaces, question.pair) : std::vector<SurfacePair>();
  touching_pairs_ = curves.touching_pairs;
  const std::vector<FoundRegion> found = find_regions(surfaces, curves, inside);
  list_curves(curves, surfaces, reader.origin());
  list_regions(found, surfaces);
  lead_out(found, curves, surfaces, reader.origin());
}

void RegionReport::list_curves(const IntersectionCurves& found, Span<const Surface> surfaces, Vec3d origin) {
  for (const Curve& curve : found.curves) {
    IntersectionCurve listed{};
    listed.body_a = surfaces[curve.surface_a].id;
    listed.body_b = surfaces[curve.surface_b].id;
    listed.is_closed = curve.is_closed;
    listed.is_perturbed = curve.is_perturbed;
    listed.first_point = static_cast<std::uint32_t>(points_.size());
    listed.point_count = static_cast<std::uint32_t>(curve.nodes.size());
    listed.length = length_of(curve, found, surfaces);
    curves_.push_back(listed);
    for (const std::uint32_t index : curve.nodes) {
      const CurveNode& node = found.nodes[index];
      points_.push_back({origin + point_of(node, surfaces),
                         surfaces[node.edge.surface].id,
                         {node.edge.v[0], node.edge.v[1]},
                         surfaces[node.triangle.surface].id,
                         node.triangle.triangle,
                         0});
    }
  }
}

void RegionReport::list_regions(Span<const FoundRegion> found, Span<const Surface> surfaces) {
  for (const FoundRegion& region : found) {
    IntersectionRegion listed{};
    listed.body = surfaces[region.surface].id;
    listed.other = surfaces[region.other].id;
    listed.kind = region.kind;
    listed.is_inside = region.is_inside;
    listed.first_vertex = static_cast<std::uint32_t>(vertices_.size());
    listed.vertex_count = static_cast<std::uint32_t>(region.vertices.size());
    listed.first_triangle = static_cast<std::uint32_t>(triangles_.size());
    listed.triangle_count = static_cast<std::uint32_t>(region.triangles.size());
    listed.first_curve = static_cast<std::uint32_t>(region_curves_.size());
    listed.curve_count = static_cast<std::uint32_t>(region.curves.size());
    listed.area = region.area;
    for (const std::uint32_t curve : region.curves) {
      listed.curve_length += curves_[curve].length;
      listed.is_perturbed |= curves_[curve].is_perturbed;
    }
    regions_.push_back(listed);
    for (const std::uint32_t v : region.vertices) vertices_.push_back({v, 0, {0, 0, 0}, 0});
    triangles_.insert(triangles_.end(), region.triangles.begin(), region.triangles.end());
    region_curves_.insert(region_curves_.end(), region.curves.begin(), region.curves.end());
  }
}

RegionReport::Search& RegionReport::search_for(BodyId other) {
  const auto at = std::find_if(searches_.begin(), searches_.end(), [&](const Search& s) { return s.other == other; });
  if (at != searches_.end()) return *at;
  return searches_.emplace_back(Search{other, {}, {}});
}

void RegionReport::lead_out(Span<const FoundRegion> found, const IntersectionCurves& curves,
                            Span<const Surface> surfaces, Vec3d origin) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    const FoundRegion& region = found[i];
    const Surface& surface = surfaces[region.surface];
    if (region.kind == RegionKind::open || region.kind == RegionKind::degenerate) {
      shorten_curves(i, region, curves, surfaces);
    } else if (region.surface == region.other) {
      lead_to_opposite(i, found, surface);
    } else if (!region.vertices.empty()) {
      Search& search = search_for(surfaces[region.other].id);
      for (std::uint32_t v = 0; v < regions_[i].vertex_count; ++v) {
        const std::uint32_t index = regions_[i].first_vertex + v;
        search.points.push_back({origin + surface.position(vertices_[index].vertex)});
        search.vertices.push_back(index);
      }
    }
  }
}

void RegionReport::lead_to(const SceneStore& scene, const RegionQuestion& question, const Search& search,
                           Span<const ClosestPoint> closest) {
  const SurfaceReader reader(scene, question);
  const Surface other = reader.surface(number_of(search.other, question.bodies));
  for (std::size_t i = 0; i < search.points.size(); ++i) {
    if (!closest[i].has_point()) continue;
    const Triangle triangle = other.triangle(closest[i].triangle);
    set_way_out(vertices_[search.vertices[i]], offset_to(search.points[i].point - reader.origin(), other, triangle));
  }
}

/// Leads to the regions at the same curves, and to the triangles of the curves' other traces.
void RegionReport::lead_to_opposite(std::size_t index, Span<const FoundRegion> found, const Surface& surface) {
  const FoundRegion& region = found[index];
  std::vector<std::uint32_t> targets = region.opposite;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i == index || found[i].surface != region.surface || found[i].other != region.other) continue;
    const bool has_curve = std::any_of(found[i].curves.begin(), found[i].curves.end(), [&](std::uint32_t curve) {
      return std::binary_search(region.curves.begin(), region.curves.end(), curve);
    });
    if (has_curve) targets.insert(targets.end(), found[i].triangles.begin(), found[i].triangles.end());
  }
  std::sort(targets.begin(), targets.end());
  targets.erase(std::unique(targets.begin(), targets.end()), targets.end());
  for (std::uint32_t i = 0; i < regions_[index].vertex_count; ++i) {
    RegionVertex& vertex = vertices_[regions_[index].first_vertex + i];
    const Vec3d x = surface.position(vertex.vertex);
    double nearest = kInfiniteDistance;
    Vec3d offset{0, 0, 0};
    for (const std::uint32_t t : targets) {
      const Triangle triangle = surface.triangle(t);
      if (has_vertex(triangle, vertex.vertex)) continue;
      const Vec3d to_triangle = offset_to(x, surface, triangle);
      if (squared_norm(to_triangle) >= nearest) continue;
      nearest = squared_norm(to_triangle);
      offset = to_triangle;
    }
    set_way_out(vertex, offset);
  }
}

void RegionReport::shorten_curves(std::size_t index, const FoundRegion& found, const IntersectionCurves& curves,
                                  Span<const Surface> surfaces) {
  const IntersectionRegion& region = regions_[index];
  std::vector<Vec3d> offsets(region.vertex_count, Vec3d{0, 0, 0});
  for (const std::uint32_t c : found.curves) {
    const std::vector<LengthGradient> gradient = length_gradient(curves.curves[c], curves, surfaces);
    double squared = 0;
    for (const LengthGradient& part : gradient) squared += squared_norm(part.gradient);
    if (!(squared > 0)) continue;
    const double step = curves_[c].length / squared;
    for (const LengthGradient& part : gradient) {
      if (part.surface != found.surface) continue;
      const auto at = std::lower_bound(found.vertices.begin(), found.vertices.end(), part.vertex);
      if (at == found.vertices.end() || *at != part.vertex) continue;
      Vec3d& offset = offsets[static_cast<std::size_t>(at - found.vertices.begin())];
      offset = offset - step * part.gradient;
    }
  }
  for (std::size_t i = 0; i < offsets.size(); ++i) set_way_out(vertices_[region.first_vertex + i], offsets[i]);
}

IntersectionRegions RegionReport::view() const {
  return {regions_, vertices_, triangles_, region_curves_, curves_, points_, touching_pairs_};
}

}  // namespace softcd::detail

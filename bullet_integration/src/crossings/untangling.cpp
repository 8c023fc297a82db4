#include "crossings/untangling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <tuple>

#include "LinearMath/btQuickprof.h"
#include "bodies/vectors.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/fields/settings.hpp"

namespace softcd::bullet {
namespace {

using Member = WorldMirror::Member;

Vec3d start_of_node(const CrossingsOfKind& kind, const Member& member, std::uint32_t node) {
  return to_doubles(member.body->m_nodes[static_cast<int>(node)].*start_of(kind.ends, *member.body));
}

/// The bounds of a body at the start of a step.
struct StartBox {
  btVector3 low, high;
};

StartBox box_at_start(const CrossingsOfKind& kind, const btSoftBody& body) {
  const NodePosition start = start_of(kind.ends, body);
  StartBox box{body.m_nodes[0].*start, body.m_nodes[0].*start};
  for (int i = 1; i < body.m_nodes.size(); ++i) {
    box.low.setMin(body.m_nodes[i].*start);
    box.high.setMax(body.m_nodes[i].*start);
  }
  return box;
}

bool overlap(const StartBox& a, const StartBox& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.low[axis] > b.high[axis] || b.low[axis] > a.high[axis]) return false;
  }
  return true;
}

bool has_ways_of_vertices(const IntersectionRegion& region) {
  return (region.kind == RegionKind::closed || region.kind == RegionKind::loop_with_border) && region.vertex_count > 0;
}

bool shortens_curves(const IntersectionRegion& region) {
  return region.kind == RegionKind::open || region.kind == RegionKind::degenerate;
}

Span<const std::uint32_t> curves_of(const IntersectionRegions& found, const IntersectionRegion& region) {
  return {found.region_curves.data() + region.first_curve, region.curve_count};
}

/// Selects the regions whose vertices move. Each curve divides two surfaces, and moving the region of one of them is
/// enough. Regions inside a closed body come first, as their side is certain, then the smaller ones. The regions of two
/// open surfaces may contradict each other: if the one lifts its right half and the other its left half, they would
/// turn around the curve for ever.
class RegionChoice {
 public:
  explicit RegionChoice(const IntersectionRegions& found) : found_(found), has_way_(found.curves.size(), false) {
    std::vector<const IntersectionRegion*> candidates;
    for (const IntersectionRegion& region : found.regions) {
      if (has_ways_of_vertices(region) && region.curve_count > 0) candidates.push_back(&region);
    }
    const auto rank = [](const IntersectionRegion* region) { return std::tuple(!region->is_inside, region->area); };
    std::stable_sort(candidates.begin(), candidates.end(),
                     [&](const auto* a, const auto* b) { return rank(a) < rank(b); });
    for (const bool may_share : {false, true}) {
      for (const IntersectionRegion* region : candidates) add(*region, may_share);
    }
  }

  const std::vector<const IntersectionRegion*>& regions() const { return regions_; }
  bool has_way(std::uint32_t curve) const { return has_way_[curve]; }

 private:
  void add(const IntersectionRegion& region, bool may_share) {
    if (std::find(regions_.begin(), regions_.end(), &region) != regions_.end()) return;
    const Span<const std::uint32_t> curves = curves_of(found_, region);
    const auto led = std::count_if(curves.begin(), curves.end(), [this](std::uint32_t c) { return has_way_[c]; });
    const bool is_free = may_share ? led < std::ptrdiff_t(curves.size()) : led == 0;
    if (!is_free && !region.is_inside) return;
    regions_.push_back(&region);
    for (const std::uint32_t curve : curves) has_way_[curve] = true;
  }

  const IntersectionRegions& found_;
  std::vector<const IntersectionRegion*> regions_;
  std::vector<bool> has_way_;
};

/// Makes the longest direction 1 long. Returns false if there is none.
bool normalize(WayOut& way) {
  btScalar longest = 0;
  for (const WayOut::End& end : way.ends) longest = btMax(longest, end.direction.length());
  if (!(longest > 0)) return false;
  for (WayOut::End& end : way.ends) end.direction /= longest;
  way.distance /= longest;
  return true;
}

/// Returns the way on which a curve becomes shorter, from the regions that lead there.
WayOut way_of_gradient(const IntersectionRegions& found, std::uint32_t curve) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, btVector3> directions;
  for (const IntersectionRegion& region : found.regions) {
    const Span<const std::uint32_t> curves = curves_of(found, region);
    if (!shortens_curves(region) || std::find(curves.begin(), curves.end(), curve) == curves.end()) continue;
    for (std::uint32_t i = 0; i < region.vertex_count; ++i) {
      const RegionVertex& vertex = found.vertices[region.first_vertex + i];
      const auto entry = directions.try_emplace({region.body.value, vertex.vertex}, btVector3(0, 0, 0)).first;
      entry->second = to_bullet(vertex.distance * vertex.direction);
    }
  }
  WayOut way;
  for (const auto& [node, direction] : directions) {
    way.ends.push_back({BodyId{node.first}, node.second, direction});
    way.distance += direction.length2();
  }
  return way;
}

/// The points of a curve at edges of one side: their mean, and the edges' nodes with their weights.
struct CurveSide {
  Vec3d sum{0, 0, 0};
  std::size_t count = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> weights = {};
};

}  // namespace

Untangling::Untangling(const CrossingsOfKind& kind, WorldMirror& mirror, const Settings& settings)
    : kind_(kind), mirror_(mirror), settings_(settings), probe_(mirror.scene(), {StepEnd::t0}) {
  follow_settings();
}

void Untangling::follow_settings() {
  const std::string problem = problem_of(settings_);
  if (!problem.empty()) throw InvalidInput(problem + ".");
}

void Untangling::clear() {
  known_.clear();
  pairs_.clear();
  nodes_.clear();
  ways_.clear();
}

bool Untangling::moves(const btSoftBody& body) const {
  return std::any_of(pairs_.begin(), pairs_.end(),
                     [&body](const IntersectingBodies& pair) { return pair.a == &body || pair.b == &body; });
}

void Untangling::find(Span<btSoftBody* const> bodies, const PairRule& rule) {
  BT_PROFILE("softcd untangling");
  std::vector<btSoftBody*> present;
  bool has_news = false;
  for (btSoftBody* body : bodies) {
    if (!has_vertex_face_contacts(kind_.ends, *body) || !mirror_.has(*body)) continue;
    present.push_back(body);
    has_news |= mirror_.member(*body).topology_changed;
  }
  if (step_++ % kStepsBetweenSearches == 0 || has_news) search({present.data(), present.size()}, rule);
  pairs_.clear();
  nodes_.clear();
  ways_.clear();
  std::vector<Pair> known;
  std::swap(known, known_);
  for (const Pair& pair : known) {
    const Member* const a = mirror_.find(pair.bodies.a);
    const Member* const b = mirror_.find(pair.bodies.b);
    if (a == nullptr || b == nullptr || !mirror_.has(*a->body) || !mirror_.has(*b->body)) continue;
    if (a == b ? !a->settings.self_collision : !rule(*a->body, *b->body)) continue;
    find_ways(pair);
  }
}

/// Finds the pairs that intersect. Those that are known keep their number of steps.
void Untangling::search(Span<btSoftBody* const> bodies, const PairRule& rule) {
  std::vector<StartBox> boxes;
  for (const btSoftBody* body : bodies) boxes.push_back(box_at_start(kind_, *body));
  std::vector<ProbeBodies> candidates;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Member& a = mirror_.member(*bodies[i]);
    if (a.settings.self_collision) candidates.push_back({a.id, a.id});
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      const Member& b = mirror_.member(*bodies[j]);
      if (a.settings.kinematic && b.settings.kinematic) continue;
      if (overlap(boxes[i], boxes[j]) && rule(*a.body, *b.body)) candidates.push_back({a.id, b.id});
    }
  }
  if (candidates.empty()) return;
  const AnswerLists<TriangleIntersection> found = probe_.intersections({candidates.data(), candidates.size()});
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const ProbeBodies& bodies_of_pair = candidates[i];
    const bool is_known = std::any_of(known_.begin(), known_.end(), [&](const Pair& pair) {
      return pair.bodies.a == bodies_of_pair.a && pair.bodies.b == bodies_of_pair.b;
    });
    if (!is_known && !found[i].empty()) known_.push_back({bodies_of_pair});
  }
  std::sort(known_.begin(), known_.end(), [](const Pair& a, const Pair& b) {
    return std::pair(a.bodies.a.value, a.bodies.b.value) < std::pair(b.bodies.a.value, b.bodies.b.value);
  });
}

/// Finds the ways out of a pair that is known to have intersected, and notes the pair if it still does. A body that is
/// inside another one without a curve stays there.
void Untangling::find_ways(Pair pair) {
  const IntersectionRegions found = probe_.intersection_regions(pair.bodies);
  if (found.curves.empty()) {
    if (++pair.clean_steps < kStepsBetweenSearches) {
      known_.push_back(pair);
    } else {
      note_end(pair);
    }
    return;
  }
  known_.push_back({pair.bodies, pair.steps + 1});
  IntersectingBodies noted{mirror_.member(pair.bodies.a).body, mirror_.member(pair.bodies.b).body};
  noted.steps = pair.steps + 1;
  noted.regions = static_cast<std::uint32_t>(found.regions.size());
  for (const IntersectionCurve& curve : found.curves) noted.curve_length += curve.length;
  pairs_.push_back(noted);

  release_curves(found);
  const RegionChoice choice(found);
  std::map<std::uint32_t, std::vector<std::pair<WayOut, ProbePoint>>> to_body;
  for (const IntersectionRegion* region : choice.regions()) {
    const Member& member = mirror_.member(region->body);
    const Member& other = mirror_.member(region->other);
    for (std::uint32_t i = 0; i < region->triangle_count; ++i) {
      const Triangle triangle = member.mesh.corners(found.triangles[region->first_triangle + i]);
      for (const std::uint32_t v : triangle.v) nodes_.add(member.body->m_nodes[static_cast<int>(v)], *other.body);
    }
    const btScalar margin = member.settings.margin + other.settings.margin;
    for (std::uint32_t i = 0; i < region->vertex_count; ++i) {
      const RegionVertex& vertex = found.vertices[region->first_vertex + i];
      const Vec3d target = start_of_node(kind_, member, vertex.vertex) + vertex.distance * vertex.direction;
      WayOut way{{{member.id, vertex.vertex, to_bullet(vertex.direction)}}, btScalar(vertex.distance) + margin};
      to_body[other.id.value].push_back({way, {target}});
    }
  }
  for (std::uint32_t curve = 0; curve < found.curves.size(); ++curve) {
    if (choice.has_way(curve)) continue;
    WayOut way = way_of_gradient(found, curve);
    if (way.ends.empty()) way = way_of_edges(found, found.curves[curve]);
    if (normalize(way)) ways_.push_back(way);
  }
  // From here on `found` is no longer valid.
  for (const auto& [id, ways] : to_body) lead_to_faces(BodyId{id}, ways);
}

void Untangling::lead_to_faces(BodyId other, const std::vector<std::pair<WayOut, ProbePoint>>& ways) {
  std::vector<ProbePoint> points;
  points.reserve(ways.size());
  for (const auto& [way, point] : ways) points.push_back(point);
  probe_.set_body_filter([other](BodyId body) { return body == other; });
  const Span<const ClosestPoint> closest = probe_.closest_points({points.data(), points.size()});
  probe_.set_body_filter({});
  const Member& member = mirror_.member(other);
  for (std::size_t i = 0; i < ways.size(); ++i) {
    WayOut way = ways[i].first;
    const WayOut::End first = way.ends.front();
    if (!closest[i].has_point() || closest[i].triangle >= member.mesh.face_count) continue;
    const Triangle triangle = member.mesh.corners(closest[i].triangle);
    if (first.body == other && has_vertex(triangle, first.node)) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const btScalar weight = btScalar(closest[i].weights[corner]);
      way.ends.push_back({other, triangle.v[corner], -weight * first.direction});
    }
    if (first.direction.length2() > 0) ways_.push_back(way);
  }
}

/// Returns the way on which the edges of one body, or the first edge of a body with itself, move to the other edges
/// that a curve meets. Such a curve is around an overlap of edges that has no vertex in it.
WayOut Untangling::way_of_edges(const IntersectionRegions& found, const IntersectionCurve& curve) const {
  const CurvePoint& first = found.points[curve.first_point];
  const bool is_within_body = curve.body_a == curve.body_b;
  std::array<CurveSide, 2> sides;
  for (std::uint32_t i = 0; i < curve.point_count; ++i) {
    const CurvePoint& point = found.points[curve.first_point + i];
    const bool is_first = is_within_body ? std::equal(std::begin(point.edge), std::end(point.edge), first.edge)
                                         : point.edge_body == first.edge_body;
    CurveSide& side = sides[is_first ? 0 : 1];
    side.sum = side.sum + point.position;
    ++side.count;
    const Member& member = mirror_.member(point.edge_body);
    const Vec3d from = start_of_node(kind_, member, point.edge[0]);
    const Vec3d along = start_of_node(kind_, member, point.edge[1]) - from;
    const double squared = squared_norm(along);
    const double share = squared > 0 ? std::clamp(dot(point.position - from, along) / squared, 0.0, 1.0) : 0.5;
    side.weights[{member.id.value, point.edge[0]}] += 1 - share;
    side.weights[{member.id.value, point.edge[1]}] += share;
  }
  if (sides[0].count == 0 || sides[1].count == 0) return {};
  const Vec3d offset = (1.0 / double(sides[1].count)) * sides[1].sum - (1.0 / double(sides[0].count)) * sides[0].sum;
  const double distance = std::sqrt(squared_norm(offset));
  if (!(distance > 0)) return {};
  WayOut way;
  way.distance =
      btScalar(distance) + mirror_.member(curve.body_a).settings.margin + mirror_.member(curve.body_b).settings.margin;
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    const double scale = (i == 0 ? 1 : -1) / (distance * double(sides[i].count));
    for (const auto& [node, weight] : sides[i].weights) {
      way.ends.push_back({BodyId{node.first}, node.second, to_bullet((scale * weight) * offset)});
    }
  }
  return way;
}

/// Releases the nodes of the edges and triangles along the curves.
void Untangling::release_curves(const IntersectionRegions& found) {
  for (const CurvePoint& point : found.points) {
    const Member& a = mirror_.member(point.edge_body);
    const Member& b = mirror_.member(point.triangle_body);
    for (const std::uint32_t v : point.edge) nodes_.add(a.body->m_nodes[static_cast<int>(v)], *b.body);
    const Triangle triangle = b.mesh.corners(point.triangle);
    for (const std::uint32_t v : triangle.v) nodes_.add(b.body->m_nodes[static_cast<int>(v)], *a.body);
  }
}

void Untangling::note_end(const Pair& pair) const {
  if (pair.steps == 0 || !settings_.log) return;  // triangles only touched
  settings_.log(LogLevel::information,
                "untangling: " + std::string(pair.bodies.a == pair.bodies.b ? "a soft body" : "two soft bodies") +
                    " came apart after " + std::to_string(pair.steps) + " steps");
}

void Untangling::move(btScalar time_step) {
  if (pairs_.empty()) return;
  BT_PROFILE("softcd untangling");
  NodesOnWaysOut(kind_, mirror_).move(ways_, btScalar(settings_.untangle_speed) * time_step, time_step);
  for (const Pair& pair : known_) {
    if (pair.clean_steps > 0) continue;
    for (const BodyId id : {pair.bodies.a, pair.bodies.b}) {
      const Member* const member = mirror_.find(id);
      if (member == nullptr) continue;
      kind_.set_out(*member->body, time_step);
      member->body->activate();
    }
  }
}

}  // namespace softcd::bullet

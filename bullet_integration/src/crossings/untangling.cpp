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
#include "softcd/mesh/features.hpp"

namespace softcd::bullet {
namespace {

using Member = WorldMirror::Member;

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

ProbeBodies by_ids(BodyId a, BodyId b) {
  return a.value < b.value ? ProbeBodies{a, b} : ProbeBodies{b, a};
}

bool are_same(const ProbeBodies& a, const ProbeBodies& b) {
  return a.a == b.a && a.b == b.b;
}

/// Makes the longest direction 1 long. Returns false if there is none.
bool normalize(WayOut& way) {
  btScalar longest = 0;
  for (const WayOut::End& end : way.ends) longest = btMax(longest, end.direction.length());
  if (!(longest > 0)) return false;
  for (WayOut::End& end : way.ends) end.direction /= longest;
  way.distance /= longest;
  return true;
}

/// Returns the way on which a curve becomes shorter, from the regions that lead there. Returns none if one of them has
/// further curves: its directions are sums for all of these, and would add momentum to a way for one.
WayOut way_of_gradient(const IntersectionRegions& found, std::uint32_t curve) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, btVector3> directions;
  for (const IntersectionRegion& region : found.regions) {
    const Span<const std::uint32_t> curves = curves_of(found, region);
    if (!shortens_curves(region) || std::find(curves.begin(), curves.end(), curve) == curves.end()) continue;
    if (curves.size() > 1) return {};
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

/// Speed at which nodes may move where the settings have none, in lengths of edges a second. A step of 1/60 s moves a
/// node by a third of an edge, so that springs are not stretched much, whatever the units.
constexpr double kEdgesPerSecond = 20;

/// The points of a curve at edges of one side: their mean, and the edges' nodes with their weights.
struct CurveSide {
  Vec3d sum{0, 0, 0};
  std::size_t count = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> weights = {};
};

}  // namespace

Untangling::Untangling(const CrossingsOfKind& kind, WorldMirror& mirror, const Settings& settings)
    : kind_(kind), mirror_(mirror), settings_(settings) {
  follow_settings();
}

/// Makes the probe when it is first needed: most worlds do not untangle.
Probe& Untangling::probe() {
  if (!probe_) probe_.emplace(mirror_.scene(), ProbeOptions{StepEnd::t0});
  return *probe_;
}

void Untangling::follow_settings() {
  const std::string problem = problem_of(settings_);
  if (!problem.empty()) throw InvalidInput(problem + ".");
}

void Untangling::begin_step() {
  pairs_.clear();
  nodes_.clear();
  ways_.clear();
  impulses_.clear();
  parts_.clear();
  ++step_;
}

void Untangling::clear() {
  begin_step();
  known_.clear();
  known_in_meshes_.clear();
  seen_.clear();
  near_.clear();
  in_world_.clear();
  from_start_.clear();
  step_ = 0;
}

bool Untangling::moves(const btSoftBody& body) const {
  return std::any_of(pairs_.begin(), pairs_.end(),
                     [&body](const IntersectingBodies& pair) { return pair.a == &body || pair.b == &body; });
}

void Untangling::find(Span<btSoftBody* const> bodies, const PairRule& rule, Span<const ProbeBodies> tangled) {
  BT_PROFILE("softcd untangling");
  std::vector<btSoftBody*> present;
  bool has_news = false;
  for (btSoftBody* body : bodies) {
    if (!has_vertex_face_contacts(kind_.ends, *body) || !mirror_.has(*body)) continue;
    present.push_back(body);
    has_news |= mirror_.member(*body).topology_changed;
  }
  if (is_search_step() || has_news) {
    search({present.data(), present.size()}, rule);
  } else {
    search(tangled);
  }
  seen_.clear();
  for (const btSoftBody* body : present) seen_.push_back(mirror_.member(*body).id);
  std::vector<Pair> known;
  std::swap(known, known_);
  for (const Pair& pair : known) {
    const Member* const a = mirror_.find(pair.bodies.a);
    const Member* const b = mirror_.find(pair.bodies.b);
    if (a == nullptr || b == nullptr || !mirror_.has(*a->body) || !mirror_.has(*b->body)) continue;
    if (!is_awake(pair)) {  // the rule admits no such pair
      known_.push_back(pair);
      continue;
    }
    if (a == b ? !a->settings.self_collision : !rule(*a->body, *b->body)) continue;
    is_moved(pair) ? find_ways(pair, known_) : known_.push_back(pair);
  }
}

/// Returns whether this step moves the pair apart if it intersects. It does not if the settings leave the pair to the
/// app, after a vain attempt, and if its soft bodies sleep.
bool Untangling::is_moved(const Pair& pair) const {
  return !is_left_to_app(pair) && step_ >= pair.resumes_at && (pair.attempt_step > 0 || is_awake(pair));
}

bool Untangling::is_left_to_app(const Pair& pair) const {
  if (settings_.untangle == Untangle::all) return false;
  return (pair.is_from_start && !parts_from_start(pair)) || has_filters(pair);
}

/// Returns whether Untangle::automatic moves a pair apart that intersects from the start. With `ccd` nothing drives
/// such a pair.
bool Untangling::parts_from_start(const Pair& pair) const {
  if (settings_.untangle != Untangle::automatic || settings_.detection != Detection::dcd) return false;
  const bool is_with_mesh = mirror_.find(pair.bodies.b) == nullptr;
  return is_with_mesh || kind_.parts_soft_bodies_from_start;
}

/// Returns whether the app has set filters of one of the bodies. They may let nodes through.
bool Untangling::has_filters(const Pair& pair) const {
  const auto is_filtered = [this](BodyId id) {
    const Member* const member = mirror_.find(id);
    return member != nullptr && member->filters != 0;
  };
  return is_filtered(pair.bodies.a) || is_filtered(pair.bodies.b);
}

/// Returns whether a soft body of the pair is awake.
bool Untangling::is_awake(const Pair& pair) const {
  const auto is_active = [this](BodyId id) {
    const Member* const member = mirror_.find(id);
    return member != nullptr && member->body->isActive();
  };
  return is_active(pair.bodies.a) || is_active(pair.bodies.b);
}

/// Notes the length of the pair's way out, and gives the pair up for a while at the end of an attempt that has not made
/// the way shorter.
void Untangling::judge_attempt(Pair& pair, double way) const {
  if (pair.attempt_step == 0) pair.way_at_attempt = way;
  if (++pair.attempt_step <= kStepsOfAttempt) return;
  pair.attempt_step = 0;
  if (way < pair.way_at_attempt) {
    pair.vain_attempts = 0;
    return;
  }
  constexpr unsigned kMostDoublings = 16;
  pair.resumes_at = step_ + (kStepsBetweenSearches << std::min(pair.vain_attempts++, kMostDoublings));
}

bool Untangling::was_in_world(const BodyKey& body) const {
  return std::find(in_world_.begin(), in_world_.end(), body) != in_world_.end();
}

/// Returns whether an intersection of these bodies is as the app has placed them.
bool Untangling::is_from_start(const NearRigidPart& part) const {
  const BodyKey soft(*part.soft);
  const BodyKey object(*part.object);
  return !was_in_world(soft) || !was_in_world(object) ||
         std::find(from_start_.begin(), from_start_.end(), std::pair(soft, object)) != from_start_.end();
}

void Untangling::note_end_of_step(const btCollisionObjectArray& objects) {
  in_world_.clear();
  for (const btCollisionObject* object : span_of(objects)) in_world_.emplace_back(*object);
  std::erase_if(from_start_, [this](const auto& bodies) {
    return !was_in_world(bodies.first) || !was_in_world(bodies.second) || bodies.first.object->isActive();
  });
  for (const Pair& pair : known_in_meshes_) {
    const Member* const soft = mirror_.find(pair.bodies.a);
    const NearRigidPart* const part = find_part(pair.bodies.b);
    if (!pair.is_from_start || soft == nullptr || part == nullptr) continue;
    from_start_.emplace_back(BodyKey(*soft->body), BodyKey(*part->object));
  }
}

bool Untangling::search_in_meshes(Span<const NearRigidPart> near_parts) {
  BT_PROFILE("softcd untangling");
  std::vector<Candidate> candidates;
  std::vector<std::pair<BodyId, BodyId>> near_now;
  for (const NearRigidPart& each : near_parts) {
    const Member& soft = mirror_.member(*each.soft);
    if (soft.mesh.face_count == 0) continue;
    if (soft.settings.kinematic && each.object->isStaticOrKinematicObject()) continue;
    near_now.emplace_back(soft.id, each.part);
    const bool was_near = std::find(near_.begin(), near_.end(), near_now.back()) != near_.end();
    if (was_near && !soft.topology_changed && !is_search_step()) continue;
    candidates.push_back({{soft.id, each.part}, !was_near && is_from_start(each)});
  }
  near_ = std::move(near_now);
  return search({candidates.data(), candidates.size()}, known_in_meshes_);
}

void Untangling::find_in_meshes(Span<const NearRigidPart> near_parts) {
  if (known_in_meshes_.empty()) return;
  BT_PROFILE("softcd untangling");
  for (const NearRigidPart& each : near_parts) parts_.emplace(each.part.value, each);
  std::vector<Pair> known;
  std::swap(known, known_in_meshes_);
  for (const Pair& pair : known) {
    if (std::find(near_.begin(), near_.end(), std::pair(pair.bodies.a, pair.bodies.b)) == near_.end()) continue;
    is_moved(pair) ? find_ways(pair, known_in_meshes_) : known_in_meshes_.push_back(pair);
  }
}

bool Untangling::knows(const btSoftBody& soft, BodyId part) const {
  return std::any_of(known_in_meshes_.begin(), known_in_meshes_.end(), [&](const Pair& pair) {
    const Member* const member = mirror_.find(pair.bodies.a);
    return member != nullptr && member->body == &soft && pair.bodies.b == part && is_moved(pair);
  });
}

const NearRigidPart* Untangling::find_part(BodyId id) const {
  const auto known = parts_.find(id.value);
  return known == parts_.end() ? nullptr : &known->second;
}

const btCollisionObject& Untangling::object_of(BodyId id) const {
  const NearRigidPart* const part = find_part(id);
  return part != nullptr ? *part->object : *mirror_.member(id).body;
}

btScalar Untangling::margin_of(BodyId id) const {
  const NearRigidPart* const part = find_part(id);
  return part != nullptr ? part->margin : btScalar(mirror_.member(id).settings.margin);
}

Triangle Untangling::corners_of(BodyId id, std::uint32_t triangle) const {
  const NearRigidPart* const part = find_part(id);
  return part != nullptr ? part->shape->triangles()[triangle] : mirror_.member(id).mesh.corners(triangle);
}

Vec3d Untangling::start_of_node(BodyId id, std::uint32_t node) const {
  if (const NearRigidPart* const part = find_part(id)) return part->shape->x_t0()[node];
  const Member& member = mirror_.member(id);
  return member.place(node, kind_.ends.start);
}

/// Releases a node from contacts with the other body. Vertices of meshes have no contacts of their own.
void Untangling::release(BodyId id, std::uint32_t node, BodyId other) {
  if (find_part(id) != nullptr) return;
  nodes_.add(mirror_.member(id).node(node), object_of(other));
}

/// Adds the way, with the ends at vertices of a mesh as one end of its object.
void Untangling::add_way(WayOut way) {
  std::erase_if(way.ends, [&](const WayOut::End& end) {
    const NearRigidPart* const part = find_part(end.body);
    if (part == nullptr) return false;
    way.rigid.object = part->object;
    const btVector3 start = to_bullet(part->shape->x_t0()[end.node]);
    const btVector3 motion = to_bullet(part->shape->x_t1()[end.node]) - start;
    way.rigid.add(end.direction, start - part->object->getWorldTransform().getOrigin(), motion);
    return true;
  });
  ways_.push_back(std::move(way));
}

/// Finds the pairs of soft bodies that intersect.
void Untangling::search(Span<btSoftBody* const> bodies, const PairRule& rule) {
  std::vector<Bounds> boxes;
  for (const btSoftBody* body : bodies) boxes.push_back(bounds_of(*body, {kind_.ends.start}));
  const auto is_new = [this](const Member& member) {
    return std::find(seen_.begin(), seen_.end(), member.id) == seen_.end();
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Member& a = mirror_.member(*bodies[i]);
    if (a.settings.self_collision && a.mesh.face_count > 0) candidates.push_back({{a.id, a.id}, is_new(a)});
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      const Member& b = mirror_.member(*bodies[j]);
      if (a.settings.kinematic && b.settings.kinematic) continue;
      if (a.mesh.face_count == 0 && b.mesh.face_count == 0) continue;
      if (boxes[i].overlaps(boxes[j]) && rule(*a.body, *b.body)) {
        candidates.push_back({by_ids(a.id, b.id), is_new(a) || is_new(b)});
      }
    }
  }
  std::erase_if(known_, [&](const Pair& pair) {
    return is_awake(pair) && !is_moved(pair) &&
           std::none_of(candidates.begin(), candidates.end(),
                        [&pair](const Candidate& candidate) { return are_same(candidate.bodies, pair.bodies); });
  });
  search({candidates.data(), candidates.size()}, known_);
}

/// Searches for the pairs that are not known yet. Both bodies were in the world a step ago.
void Untangling::search(Span<const ProbeBodies> tangled) {
  std::vector<Candidate> candidates;
  const auto is_read = [this](BodyId id) {
    const Member* const member = mirror_.find(id);
    return member != nullptr && mirror_.has(*member->body);
  };
  const auto has = [](const auto& pairs, const ProbeBodies& bodies) {
    return std::any_of(pairs.begin(), pairs.end(), [&](const auto& pair) { return are_same(pair.bodies, bodies); });
  };
  for (const ProbeBodies& pair : tangled) {
    const ProbeBodies bodies = by_ids(pair.a, pair.b);
    if (has(known_, bodies) || has(candidates, bodies) || !is_read(pair.a) || !is_read(pair.b)) continue;
    candidates.push_back({bodies, /*is_from_start=*/false});
  }
  search({candidates.data(), candidates.size()}, known_);
}

/// Adds the candidates that intersect, and returns whether any is new. Known ones keep their number of steps. Those
/// that the settings leave to the app, and those that wait for the next attempt, are forgotten when they have come
/// apart.
bool Untangling::search(Span<const Candidate> candidates, std::vector<Pair>& known) {
  bool has_new = false;
  for (const auto& [bodies, is_from_start] : candidates) {
    const auto same = std::find_if(known.begin(), known.end(),
                                   [&bodies = bodies](const Pair& pair) { return are_same(pair.bodies, bodies); });
    if (same != known.end() && is_moved(*same)) continue;
    const bool intersects = probe().has_intersections(bodies);
    if (same == known.end() && intersects) {
      known.push_back({bodies, is_from_start});
      has_new = true;
    } else if (same != known.end() && !intersects) {
      known.erase(same);
    }
  }
  std::sort(known.begin(), known.end(), [](const Pair& a, const Pair& b) {
    return std::pair(a.bodies.a.value, a.bodies.b.value) < std::pair(b.bodies.a.value, b.bodies.b.value);
  });
  return has_new;
}

/// Finds the ways out of a pair that is known to have intersected, and notes the pair if it still does. A body that is
/// inside another one without a curve stays there.
void Untangling::find_ways(Pair pair, std::vector<Pair>& known) {
  const IntersectionRegions found = probe().intersection_regions(pair.bodies);
  if (found.curves.empty()) {
    if (++pair.clean_steps < kStepsOfAttempt) {
      known.push_back(pair);
    } else {
      note_end(pair);
    }
    return;
  }
  ++pair.steps;
  pair.clean_steps = 0;
  pair.moved_at = step_;
  IntersectingBodies noted{mirror_.member(pair.bodies.a).body, &object_of(pair.bodies.b)};
  noted.steps = pair.steps;
  noted.regions = static_cast<std::uint32_t>(found.regions.size());
  for (const IntersectionCurve& curve : found.curves) noted.curve_length += curve.length;
  pairs_.push_back(noted);

  const RegionChoice choice(found);
  const btScalar speed = speed_of_ways(found);
  double length = 0;
  std::map<std::uint32_t, std::vector<std::pair<WayOut, ProbePoint>>> to_body;
  for (const IntersectionRegion* region : choice.regions()) {
    const btScalar margin = margin_of(region->body) + margin_of(region->other);
    for (std::uint32_t i = 0; i < region->vertex_count; ++i) {
      const RegionVertex& vertex = found.vertices[region->first_vertex + i];
      release(region->body, vertex.vertex, region->other);
      length += vertex.distance;
      const Vec3d target = start_of_node(region->body, vertex.vertex) + vertex.distance * vertex.direction;
      WayOut way;
      way.ends.push_back({region->body, vertex.vertex, to_bullet(vertex.direction)});
      way.distance = btScalar(vertex.distance) + margin;
      way.speed = speed;
      to_body[region->other.value].push_back({way, {target}});
    }
  }
  for (std::uint32_t curve = 0; curve < found.curves.size(); ++curve) {
    // Contacts at the curves of bodies that intersect from the start only add energy. Where a blow has pushed nodes
    // through, those beside them carry load. Without contacts more and more would follow.
    if (pair.is_from_start || !choice.has_way(curve)) release(found, found.curves[curve]);
    if (choice.has_way(curve)) continue;
    length += found.curves[curve].length;
    WayOut way = way_of_gradient(found, curve);
    if (way.ends.empty()) way = way_of_edges(found, found.curves[curve]);
    way.speed = speed;
    if (normalize(way)) add_way(way);
  }
  judge_attempt(pair, length);
  known.push_back(pair);
  // From here on `found` is no longer valid.
  for (const auto& [id, ways] : to_body) lead_to_faces(BodyId{id}, ways);
}

/// Returns the greatest speed of nodes: that of the settings, or one that suits the edges along the curves.
btScalar Untangling::speed_of_ways(const IntersectionRegions& found) const {
  if (settings_.untangle_speed > 0) return btScalar(settings_.untangle_speed);
  double sum = 0;
  for (const CurvePoint& point : found.points) {
    const Vec3d from = start_of_node(point.edge_body, point.edge[0]);
    sum += std::sqrt(squared_norm(start_of_node(point.edge_body, point.edge[1]) - from));
  }
  return btScalar(kEdgesPerSecond * sum / double(found.points.size()));
}

void Untangling::lead_to_faces(BodyId other, const std::vector<std::pair<WayOut, ProbePoint>>& ways) {
  std::vector<ProbePoint> points;
  points.reserve(ways.size());
  for (const auto& [way, point] : ways) points.push_back(point);
  probe().set_body_filter([other](BodyId body) { return body == other; });
  const Span<const ClosestPoint> closest = probe().closest_points({points.data(), points.size()});
  probe().set_body_filter({});
  const bool is_rigid = find_part(other) != nullptr;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    WayOut way = ways[i].first;
    const WayOut::End first = way.ends.front();
    if (!closest[i].has_point()) continue;
    if (!is_rigid && closest[i].triangle >= mirror_.member(other).mesh.face_count) continue;
    const Triangle triangle = corners_of(other, closest[i].triangle);
    if (first.body == other && has_vertex(triangle, first.node)) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const btScalar weight = btScalar(closest[i].weights[corner]);
      way.ends.push_back({other, triangle.v[corner], -weight * first.direction});
    }
    if (first.direction.length2() > 0) add_way(way);
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
    const BodyId body = point.edge_body;
    const Vec3d from = start_of_node(body, point.edge[0]);
    const Vec3d along = start_of_node(body, point.edge[1]) - from;
    const double squared = squared_norm(along);
    const double share = squared > 0 ? std::clamp(dot(point.position - from, along) / squared, 0.0, 1.0) : 0.5;
    side.weights[{body.value, point.edge[0]}] += 1 - share;
    side.weights[{body.value, point.edge[1]}] += share;
  }
  if (sides[0].count == 0 || sides[1].count == 0) return {};
  const Vec3d offset = (1.0 / double(sides[1].count)) * sides[1].sum - (1.0 / double(sides[0].count)) * sides[0].sum;
  const double distance = std::sqrt(squared_norm(offset));
  if (!(distance > 0)) return {};
  WayOut way;
  way.distance = btScalar(distance) + margin_of(curve.body_a) + margin_of(curve.body_b);
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    const double scale = (i == 0 ? 1 : -1) / (distance * double(sides[i].count));
    for (const auto& [node, weight] : sides[i].weights) {
      way.ends.push_back({BodyId{node.first}, node.second, to_bullet((scale * weight) * offset)});
    }
  }
  return way;
}

/// Releases the nodes of the edges and triangles along the curve.
void Untangling::release(const IntersectionRegions& found, const IntersectionCurve& curve) {
  for (std::uint32_t i = 0; i < curve.point_count; ++i) {
    const CurvePoint& point = found.points[curve.first_point + i];
    for (const std::uint32_t v : point.edge) release(point.edge_body, v, point.triangle_body);
    const Triangle triangle = corners_of(point.triangle_body, point.triangle);
    for (const std::uint32_t v : triangle.v) release(point.triangle_body, v, point.edge_body);
  }
}

void Untangling::note_end(const Pair& pair) const {
  if (pair.steps == 0 || !settings_.log) return;  // triangles only touched
  const char* bodies = "two soft bodies";
  if (pair.bodies.a == pair.bodies.b) bodies = "a soft body";
  if (find_part(pair.bodies.b) != nullptr) bodies = "a soft body and a rigid mesh";
  settings_.log(LogLevel::information,
                std::string("untangling: ") + bodies + " came apart after " + std::to_string(pair.steps) + " steps");
}

void Untangling::move(const btCollisionObjectArray& objects, btScalar time_step) {
  note_end_of_step(objects);
  if (pairs_.empty()) return;
  BT_PROFILE("softcd untangling");
  NodesOnWaysOut nodes(kind_, mirror_, objects, settings_.read_out == ReadOut::impulses);
  nodes.move(ways_, time_step);
  impulses_ = nodes.impulses();
  for (const std::vector<Pair>* known : {&known_, &known_in_meshes_}) {
    for (const Pair& pair : *known) {
      if (pair.moved_at != step_) continue;
      for (const BodyId id : {pair.bodies.a, pair.bodies.b}) {
        const Member* const member = mirror_.find(id);
        if (member == nullptr) continue;
        kind_.set_out(*member->body, time_step);
        member->body->activate();
      }
    }
  }
}

}  // namespace softcd::bullet

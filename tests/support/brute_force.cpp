#include "brute_force.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <sstream>
#include <utility>

#include "box_sweep.hpp"
#include "exact_ccd.hpp"
#include "scene_geometry.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::test {
namespace {

bool is_finite(Vec3d p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// A body's features that take part: those of triangles and segments whose vertices are all finite.
struct FeatureLists {
  std::vector<std::uint32_t> vertices;
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> edge_ids;
  std::vector<Edge> edges;
};

FeatureLists features_of_body(const SceneBody& body) {
  FeatureLists lists;
  SceneBody active;
  std::vector<bool> is_used(body.x_t1.size(), false);
  const auto take = [&](const auto& vertices) {
    const bool finite = std::all_of(std::begin(vertices), std::end(vertices), [&](std::uint32_t v) {
      return is_finite(body.x_t0[v]) && is_finite(body.x_t1[v]);
    });
    for (const std::uint32_t v : vertices) is_used[v] = is_used[v] || finite;
    return finite;
  };
  for (std::uint32_t t = 0; t < body.triangles.size(); ++t) {
    if (!take(body.triangles[t].v)) continue;
    active.triangles.push_back(body.triangles[t]);
    lists.triangles.push_back(t);
  }
  for (const Segment& segment : body.segments) {
    if (take(segment.v)) active.segments.push_back(segment);
  }
  for (std::uint32_t v = 0; v < is_used.size(); ++v) {
    if (is_used[v]) lists.vertices.push_back(v);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> ids;
  for (const Edge& edge : edges_of(body))
    ids.emplace(std::pair(edge.v[0], edge.v[1]), static_cast<std::uint32_t>(ids.size()));
  lists.edges = edges_of(active);
  const auto id_of = [&](const Edge& edge) { return ids.at({edge.v[0], edge.v[1]}); };
  // In the order of their numbers, which differs where a triangle that is left out has a segment's edge.
  std::sort(lists.edges.begin(), lists.edges.end(), [&](const Edge& a, const Edge& b) { return id_of(a) < id_of(b); });
  for (const Edge& edge : lists.edges) lists.edge_ids.push_back(id_of(edge));
  return lists;
}

bool bodies_meet(const Scene& scene, std::uint32_t a, std::uint32_t b, const PairFilter& filter) {
  const BodySettings& sa = scene[a].settings;
  const BodySettings& sb = scene[b].settings;
  const auto passes = [&] { return !filter || filter(BodyId{a}, BodyId{b}); };
  if (a == b) return sa.self_collision && passes();
  if (sa.kinematic && sb.kinematic) return false;
  if ((sa.filter_group & sb.filter_mask) == 0 || (sb.filter_group & sa.filter_mask) == 0) return false;
  return passes();
}

bool contains(const Triangle& t, std::uint32_t v) {
  return t.v[0] == v || t.v[1] == v || t.v[2] == v;
}

bool share_vertex(const Edge& e, const Edge& g) {
  return e.v[0] == g.v[0] || e.v[0] == g.v[1] || e.v[1] == g.v[0] || e.v[1] == g.v[1];
}

/// Makes boxes over both ends of the step, or over t1 alone.
struct BoxBuilder {
  bool swept;

  SweepBox vertex(const SceneBody& body, std::uint32_t v, double reach) const {
    return enclosing({swept ? body.x_t0[v] : body.x_t1[v], body.x_t1[v]}, reach);
  }
  SweepBox edge(const SceneBody& body, const Edge& e, double reach) const {
    const Positions3& start = swept ? body.x_t0 : body.x_t1;
    return enclosing({start[e.v[0]], start[e.v[1]], body.x_t1[e.v[0]], body.x_t1[e.v[1]]}, reach);
  }
  SweepBox triangle(const SceneBody& body, const Triangle& t) const {
    const Positions3& start = swept ? body.x_t0 : body.x_t1;
    const auto [a, b, c] = t.v;
    return enclosing({start[a], start[b], start[c], body.x_t1[a], body.x_t1[b], body.x_t1[c]});
  }
};

/// Visits every relevant pair of features with overlapping boxes: the bodies may touch, both want the kind, and no
/// vertex is shared. `reach(kind, a, b, vertex)` is the distance up to which a pair is relevant.
template <class Reach, class Visit>
class FeaturePairVisitor {
 public:
  FeaturePairVisitor(const Scene& scene, bool swept, const Reach& reach, const Visit& visit)
      : scene_(scene), boxes_{swept}, reach_(reach), visit_(visit) {
    for (const SceneBody& body : scene) lists_.push_back(features_of_body(body));
  }

  void run(const PairFilter& filter) const {
    for (std::uint32_t a = 0; a < scene_.size(); ++a) {
      for (std::uint32_t b = a; b < scene_.size(); ++b) {
        if (!bodies_meet(scene_, a, b, filter)) continue;
        const Features fa = scene_[a].settings.features;
        const Features fb = scene_[b].settings.features;
        if (fa.vertex_triangle && fb.vertex_triangle) visit_vertex_triangle(a, b);
        if (fa.vertex_triangle && fb.vertex_triangle && a != b) visit_vertex_triangle(b, a);
        if (fa.edge_edge && fb.edge_edge) visit_edge_edge(a, b);
      }
    }
  }

 private:
  void visit_vertex_triangle(std::uint32_t a, std::uint32_t b) const {
    std::vector<SweepBox> vertices;
    std::vector<SweepBox> triangles;
    for (const std::uint32_t v : lists_[a].vertices) {
      vertices.push_back(boxes_.vertex(scene_[a], v, reach_(ContactKind::vertex_triangle, a, b, v)));
    }
    for (const std::uint32_t t : lists_[b].triangles) {
      triangles.push_back(boxes_.triangle(scene_[b], scene_[b].triangles[t]));
    }
    for_each_overlap(vertices, triangles, [&](std::uint32_t i, std::uint32_t j) {
      const std::uint32_t v = lists_[a].vertices[i];
      const std::uint32_t t = lists_[b].triangles[j];
      if (a == b && contains(scene_[a].triangles[t], v)) return;
      visit_(FeaturePair{ContactKind::vertex_triangle, a, v, b, t});
    });
  }

  void visit_edge_edge(std::uint32_t a, std::uint32_t b) const {
    std::vector<SweepBox> first;
    std::vector<SweepBox> second;
    const double reach = reach_(ContactKind::edge_edge, a, b, 0);
    for (const Edge& edge : lists_[a].edges) first.push_back(boxes_.edge(scene_[a], edge, reach));
    for (const Edge& edge : lists_[b].edges) second.push_back(boxes_.edge(scene_[b], edge, 0.0));
    for_each_overlap(first, second, [&](std::uint32_t i, std::uint32_t j) {
      if (a == b && (i >= j || share_vertex(lists_[a].edges[i], lists_[a].edges[j]))) return;
      visit_(FeaturePair{ContactKind::edge_edge, a, lists_[a].edge_ids[i], b, lists_[b].edge_ids[j]});
    });
  }

  const Scene& scene_;
  BoxBuilder boxes_;
  const Reach& reach_;
  const Visit& visit_;
  std::vector<FeatureLists> lists_;
};

template <class Reach, class Visit>
void for_each_feature_pair(const Scene& scene, bool swept, const PairFilter& filter, const Reach& reach,
                           const Visit& visit) {
  FeaturePairVisitor<Reach, Visit>(scene, swept, reach, visit).run(filter);
}

void sort_both(Verdicts& verdicts) {
  std::sort(verdicts.certain.begin(), verdicts.certain.end());
  std::sort(verdicts.undecided.begin(), verdicts.undecided.end());
}

std::vector<FeaturePair> without(const std::vector<FeaturePair>& a, const std::vector<FeaturePair>& b) {
  std::vector<FeaturePair> rest;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(rest));
  return rest;
}

void describe_some(std::ostream& out, const char* what, const std::vector<FeaturePair>& pairs) {
  constexpr std::size_t kShown = 5;
  out << pairs.size() << ' ' << what;
  for (std::size_t i = 0; i < std::min(kShown, pairs.size()); ++i) out << (i == 0 ? ": " : "; ") << pairs[i];
  out << '\n';
}

}  // namespace

Verdicts discrete_verdicts(const Scene& scene, const DiscreteRules& rules) {
  const auto threshold = [&](ContactKind kind, std::uint32_t a, std::uint32_t b, std::uint32_t vertex) {
    double sum = static_cast<double>(scene[a].settings.margin) + static_cast<double>(scene[b].settings.margin);
    if (kind == ContactKind::vertex_triangle && a != b) {
      sum += rules.motion_margin * std::sqrt(squared_norm(scene[a].x_t1[vertex] - scene[a].x_t0[vertex]));
    }
    return sum;
  };
  const auto reach = [&](ContactKind kind, std::uint32_t a, std::uint32_t b, std::uint32_t vertex) {
    return threshold(kind, a, b, vertex) * (1.0 + 2.0 * rules.relative_band) + 2.0 * rules.absolute_band;
  };
  const SceneGeometry geometry(scene);
  Verdicts verdicts;
  for_each_feature_pair(scene, false, rules.pair_filter, reach, [&](const FeaturePair& pair) {
    const double limit = threshold(pair.kind, pair.body_a, pair.body_b, pair.feature_a);
    const double distance = geometry.distance(pair, 1.0);
    const double band = rules.relative_band * limit + rules.absolute_band;
    if (distance < limit - band) verdicts.certain.push_back(pair);
    if (std::abs(distance - limit) <= band) verdicts.undecided.push_back(pair);
  });
  sort_both(verdicts);
  return verdicts;
}

Verdicts continuous_verdicts(const Scene& scene, const PairFilter& pair_filter) {
  const SceneGeometry geometry(scene);
  const auto no_reach = [](ContactKind, std::uint32_t, std::uint32_t, std::uint32_t) { return 0.0; };
  Verdicts verdicts;
  for_each_feature_pair(scene, true, pair_filter, no_reach, [&](const FeaturePair& pair) {
    const std::array<Vec3d, 8> rows = geometry.motion(pair);
    const bool hit =
        pair.kind == ContactKind::vertex_triangle ? collides_vertex_triangle(rows) : collides_edge_edge(rows);
    if (hit) verdicts.certain.push_back(pair);
  });
  sort_both(verdicts);
  return verdicts;
}

Difference compare(const Verdicts& verdicts, const std::vector<FeaturePair>& reported) {
  std::vector<FeaturePair> sorted = reported;
  std::sort(sorted.begin(), sorted.end());
  Difference difference;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i] == sorted[i - 1]) difference.repeated.push_back(sorted[i]);
  }
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  difference.missed = without(verdicts.certain, sorted);
  difference.extra = without(without(sorted, verdicts.certain), verdicts.undecided);
  return difference;
}

bool agrees(const Difference& difference) {
  return difference.missed.empty() && difference.extra.empty() && difference.repeated.empty();
}

std::string describe(const Difference& difference) {
  std::ostringstream out;
  describe_some(out, "missed", difference.missed);
  describe_some(out, "extra", difference.extra);
  describe_some(out, "repeated", difference.repeated);
  return out.str();
}

}  // namespace softcd::test

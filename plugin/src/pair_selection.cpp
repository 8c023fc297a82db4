#include "pair_selection.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "box_pairs.hpp"

namespace softcd {
namespace {

constexpr float kLargest = std::numeric_limits<float>::max();
constexpr Box kNowhere = {{kLargest, kLargest, kLargest}, {-kLargest, -kLargest, -kLargest}};

/// What the detector takes for the body's margin: the margin as it is, where nothing was rounded. Both ends of a motion
/// may be, which is why a margin that grows with it is twice that off.
float detected_margin(float margin, double rounding, const MarginGrowth& growth) {
  if (!growth.covers_rounding || !(rounding > 0.0)) return margin;
  const double growth_per_rounding = 1.0 + 2.0 * static_cast<double>(growth.motion);
  return outward_up(margin + outward_up(static_cast<float>(growth_per_rounding * rounding)));
}

/// The box of everything that the body's features may touch, rounded as its positions are, then outward.
Box grown_box(const BodyExtent& extent, Vec3d origin, float margin, const MarginGrowth& growth) {
  if (extent.is_empty) return kNowhere;
  const Box box = {vec3_cast<float>(extent.lo - origin), vec3_cast<float>(extent.hi - origin)};
  const float motion = outward_up(outward_up(static_cast<float>(extent.furthest_move)) * growth.motion);
  return inflated(box, outward_up(outward_up(margin + motion) * growth.reach));
}

bool groups_allow(const BodySettings& a, const BodySettings& b) {
  return (a.filter_group & b.filter_mask) != 0 && (b.filter_group & a.filter_mask) != 0;
}

/// Whether somebody wants contacts between the two, which may be one and the same.
bool is_wanted(const BodySettings& a, const BodySettings& b) {
  const bool vertex_triangle = a.features.vertex_triangle && b.features.vertex_triangle;
  const bool edge_edge = a.features.edge_edge && b.features.edge_edge;
  return (vertex_triangle || edge_edge) && !(a.kinematic && b.kinematic);
}

/// Takes pairs that may touch.
class Selection {
 public:
  Selection(const std::vector<Body>& bodies, const std::vector<Box>& boxes, PairSelection& out)
      : bodies_(bodies), boxes_(boxes), out_(out) {}

  void allow(std::uint32_t a, std::uint32_t b) {
    const Features& features_a = bodies_[a].settings.features;
    const Features& features_b = bodies_[b].settings.features;
    pairs_.emplace_back(a, b);
    out_.bodies[a].reach = merged(out_.bodies[a].reach, boxes_[b]);
    out_.bodies[b].reach = merged(out_.bodies[b].reach, boxes_[a]);
    out_.vertex_triangle |= features_a.vertex_triangle && features_b.vertex_triangle;
    out_.edge_edge |= features_a.edge_edge && features_b.edge_edge;
    ++(a == b ? out_.self_count : out_.pair_count);
  }

  /// Enters every pair in both rows. In ascending order of pairs, rows become ascending.
  void write_rows() {
    std::sort(pairs_.begin(), pairs_.end());
    std::vector<std::uint64_t>& begin = out_.partner_begin;
    begin.assign(out_.bodies.size() + 1, 0);
    for (const auto& [a, b] : pairs_) {
      ++begin[a + 1];
      if (a != b) ++begin[b + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::uint64_t> next = begin;
    out_.partners.resize(begin.back());
    for (const auto& [a, b] : pairs_) {
      out_.partners[next[a]++] = b;
      if (a != b) out_.partners[next[b]++] = a;
    }
  }

 private:
  const std::vector<Body>& bodies_;
  const std::vector<Box>& boxes_;
  PairSelection& out_;
  std::vector<IndexPair> pairs_;
};

}  // namespace

PairSelection select_pairs(const std::vector<Body>& bodies, const std::vector<BodySurvey>& surveys, Vec3d origin,
                           const MarginGrowth& growth, const PairFilter& filter) {
  PairSelection out;
  std::vector<Box> boxes;
  std::uint32_t first_vertex = 0;
  std::uint32_t first_triangle = 0;
  std::uint32_t first_edge = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = bodies[b];
    const BodySettings& settings = body.settings;
    const float margin = detected_margin(settings.margin, surveys[b].rounding, growth);
    out.bodies.push_back({body.id.value, first_vertex, first_triangle, first_edge, margin,
                          settings.features.vertex_triangle, settings.features.edge_edge, /*lists_neighbours=*/false,
                          kNowhere});
    first_vertex += body.topology.vertex_count;
    first_triangle += static_cast<std::uint32_t>(body.topology.triangles.size());
    first_edge += static_cast<std::uint32_t>(body.topology.edges.size());
    boxes.push_back(grown_box(surveys[b].extent, origin, margin, growth));
  }

  Selection selection(bodies, boxes, out);
  for (std::uint32_t b = 0; b < bodies.size(); ++b) {
    const BodySettings& settings = bodies[b].settings;
    if (settings.self_collision && !surveys[b].extent.is_empty && is_wanted(settings, settings)) {
      selection.allow(b, b);
      const std::optional<NeighbourFeatures>& neighbours = bodies[b].participation.neighbours;
      out.bodies[b].lists_neighbours = neighbours && neighbours->are_listed;
    }
  }
  for (const auto& [a, b] : overlapping_pairs(boxes)) {
    // Infinite boxes reach those that are nowhere, too.
    if (surveys[a].extent.is_empty || surveys[b].extent.is_empty) continue;
    if (!groups_allow(bodies[a].settings, bodies[b].settings) || !is_wanted(bodies[a].settings, bodies[b].settings))
      continue;
    if (!filter || filter(bodies[a].id, bodies[b].id)) selection.allow(a, b);
  }
  selection.write_rows();
  return out;
}

}  // namespace softcd

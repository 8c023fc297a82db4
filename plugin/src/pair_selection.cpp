#include "pair_selection.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

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

/// Pairs (i < j) of overlapping boxes, ascending: sweep along x.
std::vector<std::pair<std::uint32_t, std::uint32_t>> overlapping_pairs(const std::vector<Box>& boxes) {
  std::vector<std::uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return boxes[a].lo.x < boxes[b].lo.x; });
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Box& box = boxes[order[i]];
    for (std::size_t j = i + 1; j < order.size() && boxes[order[j]].lo.x <= box.hi.x; ++j) {
      if (overlap(box, boxes[order[j]])) pairs.emplace_back(std::min(order[i], order[j]), std::max(order[i], order[j]));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

class Selection {
 public:
  explicit Selection(PairSelection& out) : out_(out) {}

  void allow(std::uint32_t a, std::uint32_t b, const BodySettings& settings_a, const BodySettings& settings_b,
             const Box& box_a, const Box& box_b) {
    set(a, b);
    set(b, a);
    out_.bodies[a].reach = merged(out_.bodies[a].reach, box_b);
    out_.bodies[b].reach = merged(out_.bodies[b].reach, box_a);
    out_.vertex_triangle |= settings_a.features.vertex_triangle && settings_b.features.vertex_triangle;
    out_.edge_edge |= settings_a.features.edge_edge && settings_b.features.edge_edge;
    ++(a == b ? out_.self_count : out_.pair_count);
  }

 private:
  void set(std::uint32_t row, std::uint32_t column) {
    out_.may_touch[static_cast<std::size_t>(row) * out_.pair_words + (column >> 5)] |= 1U << (column & 31U);
  }

  PairSelection& out_;
};

}  // namespace

PairSelection select_pairs(const std::vector<Body>& bodies, const std::vector<BodySurvey>& surveys, Vec3d origin,
                           const MarginGrowth& growth, const PairFilter& filter) {
  PairSelection out;
  out.pair_words = static_cast<std::uint32_t>((bodies.size() + 31) / 32);
  out.may_touch.assign(bodies.size() * out.pair_words, 0U);
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

  Selection selection(out);
  for (std::uint32_t b = 0; b < bodies.size(); ++b) {
    const BodySettings& settings = bodies[b].settings;
    if (settings.self_collision && !surveys[b].extent.is_empty && is_wanted(settings, settings)) {
      selection.allow(b, b, settings, settings, boxes[b], boxes[b]);
      const std::optional<NeighbourFeatures>& neighbours = bodies[b].participation.neighbours;
      out.bodies[b].lists_neighbours = neighbours && neighbours->are_listed;
    }
  }
  for (const auto& [a, b] : overlapping_pairs(boxes)) {
    // Infinite boxes reach those that are nowhere, too.
    if (surveys[a].extent.is_empty || surveys[b].extent.is_empty) continue;
    if (!groups_allow(bodies[a].settings, bodies[b].settings) || !is_wanted(bodies[a].settings, bodies[b].settings))
      continue;
    if (filter && !filter(bodies[a].id, bodies[b].id)) continue;
    selection.allow(a, b, bodies[a].settings, bodies[b].settings, boxes[a], boxes[b]);
  }
  return out;
}

}  // namespace softcd

#include "pair_selection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "for_each_body.hpp"
#include "softcd/grid/cell_index.hpp"

namespace softcd {
namespace {

constexpr float kLargest = std::numeric_limits<float>::max();
constexpr Box kNowhere = {{kLargest, kLargest, kLargest}, {-kLargest, -kLargest, -kLargest}};

/// Returns whether the arithmetic uses positions that were rounded, and the rounding must be compensated.
bool is_rounded(const Body& body, const Selecting& selecting) {
  const StepSurvey& survey = body.positions.survey();
  return (selecting.covers_rounding_t0 && survey.t0.is_rounded) ||
         (selecting.covers_rounding_t1 && survey.t1.is_rounded);
}

Extent extent_of(const Body& body, const Selecting& selecting) {
  Extent extent;
  if (!body.positions.are_set()) return extent;
  if (selecting.t0) extent.extend(body.positions.survey().t0.extent);
  if (selecting.t1) extent.extend(body.positions.survey().t1.extent);
  return extent;
}

/// Returns the box of everything that the body's features may touch, rounded as its positions are, then outward.
Box grown_box(const Body& body, Vec3d origin, float margin, const Selecting& selecting) {
  const Extent extent = extent_of(body, selecting);
  if (extent.is_empty()) return kNowhere;
  Box box = {vec3_cast<float>(extent.lo - origin), vec3_cast<float>(extent.hi - origin)};
  if (is_rounded(body, selecting)) {
    const auto outward = [](const Vec3f& v, float (*by)(float)) { return Vec3f{by(v.x), by(v.y), by(v.z)}; };
    box = {outward(box.lo, outward_down), outward(box.hi, outward_up)};
  }
  const auto furthest_move = static_cast<float>(std::sqrt(body.positions.survey().squared_move));
  const float motion = outward_up(outward_up(furthest_move) * selecting.motion_margin);
  return inflated(box, outward_up(outward_up(margin + motion) * selecting.distance_factor));
}

bool groups_allow(const BodySettings& a, const BodySettings& b) {
  return (a.filter_group & b.filter_mask) != 0 && (b.filter_group & a.filter_mask) != 0;
}

/// Returns the kinds of contacts that both bodies, which may be the same, take part in.
Features wanted_features(const BodySettings& a, const BodySettings& b, const Features& features) {
  if (a.kinematic && b.kinematic) return {false, false};
  return {a.features.vertex_triangle && b.features.vertex_triangle && features.vertex_triangle,
          a.features.edge_edge && b.features.edge_edge && features.edge_edge};
}

/// Spreads batches over all cells of the grid; batch 0 is not moved.
std::uint32_t cell_offset_of(std::uint32_t batch) {
  return (batch * 0x9E3779B1U) >> (32 - kCellBits);
}

/// Collects pairs that may touch, in ascending order.
class Selection {
 public:
  Selection(const std::vector<Body>& bodies, Span<const Box> boxes, const Selecting& selecting,
            const PairFilter& filter, PairSelection& out, std::vector<IndexPair>& pairs)
      : bodies_(bodies), boxes_(boxes), selecting_(selecting), filter_(filter), out_(out), pairs_(pairs) {}

  /// Takes two bodies, a <= b, whose boxes overlap. Returns whether they may touch.
  bool offer(std::uint32_t a, std::uint32_t b) {
    const Body& body_a = bodies_[a];
    const Body& body_b = bodies_[b];
    const Features features = wanted_features(body_a.settings, body_b.settings, selecting_.features);
    if (!features.vertex_triangle && !features.edge_edge) return false;
    if (std::max(body_a.last_change, body_b.last_change) <= selecting_.changed_since) return false;
    if (filter_ && !filter_(body_a.id, body_b.id)) return false;
    pairs_.emplace_back(a, b);
    out_.bodies[a].partner_box = merged(out_.bodies[a].partner_box, boxes_[b]);
    out_.bodies[b].partner_box = merged(out_.bodies[b].partner_box, boxes_[a]);
    out_.vertex_triangle |= features.vertex_triangle;
    out_.edge_edge |= features.edge_edge;
    ++(a == b ? out_.self_count : out_.pair_count);
    return true;
  }

 private:
  const std::vector<Body>& bodies_;
  Span<const Box> boxes_;
  const Selecting& selecting_;
  const PairFilter& filter_;
  PairSelection& out_;
  std::vector<IndexPair>& pairs_;
};

}  // namespace

const PairSelection& PairSelector::select(const std::vector<Body>& bodies, Vec3d origin, const Selecting& selecting,
                                          const PairFilter& filter, std::uint64_t bodies_number) {
  if (!filter && bodies_number != 0 && bodies_number == selected_of_ && selecting == selected_by_) return selection_;
  selected_of_ = 0;
  ++selection_.number;
  selection_.pair_count = selection_.self_count = 0;
  selection_.vertex_triangle = selection_.edge_edge = false;
  pairs_.clear();
  survey_bodies(bodies, origin, selecting);
  Selection selection(bodies, boxes_, selecting, filter, selection_, pairs_);
  const Span<const IndexPair> overlapping = box_pairs_.find(boxes_, batches_);
  const IndexPair* next = overlapping.begin();
  for (std::uint32_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b].settings.self_collision && !is_empty(boxes_[b]) && selection.offer(b, b)) {
      const BodyNeighbours& neighbours = bodies[b].neighbours;
      selection_.bodies[b].lists_neighbours = neighbours.are_listed;
      selection_.bodies[b].has_stars = neighbours.stars.range.begin != neighbours.stars.range.end;
    }
    for (; next != overlapping.end() && next->first == b; ++next) {
      if (groups_allow(bodies[b].settings, bodies[next->second].settings)) selection.offer(b, next->second);
    }
  }
  write_rows();
  selected_of_ = filter ? 0 : bodies_number;
  selected_by_ = selecting;
  return selection_;
}

/// Computes the data that depends on one body only.
void PairSelector::survey_bodies(const std::vector<Body>& bodies, Vec3d origin, const Selecting& selecting) {
  selection_.bodies.resize(bodies.size());
  boxes_.resize(bodies.size());
  const auto survey = [&](std::size_t b) {
    const Body& body = bodies[b];
    const Features& features = body.settings.features;
    const float margin = selecting.margins ? body.settings.margin : 0.0F;
    selection_.bodies[b] = {body.id.value,
                            body.vertices.first,
                            body.triangles.first,
                            body.edges.first,
                            margin,
                            features.vertex_triangle && selecting.features.vertex_triangle,
                            features.edge_edge && selecting.features.edge_edge,
                            /*lists_neighbours=*/false,
                            kNowhere,
                            cell_offset_of(body.settings.batch),
                            selecting.neighbour_filters && body.excludes_rings(),
                            selecting.neighbour_filters && body.excludes_at_rest() ? body.settings.rest_distance : 0.0F,
                            is_rounded(body, selecting)};
    boxes_[b] = grown_box(body, origin, margin, selecting);
  };
  for_each_body(bodies.size(), survey);
  selection_.is_rounded = std::any_of(selection_.bodies.begin(), selection_.bodies.end(),
                                      [](const SceneBody& body) { return body.is_rounded; });
  batches_.clear();
  if (std::all_of(bodies.begin(), bodies.end(), [](const Body& body) { return body.settings.batch == 0; })) return;
  for (const Body& body : bodies) batches_.push_back(body.settings.batch);
}

/// Enters every pair in both bodies' rows. The rows are ascending because the pairs are.
void PairSelector::write_rows() {
  std::vector<std::uint64_t>& begin = selection_.partner_begin;
  begin.assign(selection_.bodies.size() + 1, 0);
  for (const auto& [a, b] : pairs_) {
    ++begin[a + 1];
    if (a != b) ++begin[b + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  row_ends_.assign(begin.begin(), begin.end());
  selection_.partners.resize(begin.back());
  for (const auto& [a, b] : pairs_) {
    selection_.partners[row_ends_[a]++] = b;
    if (a != b) selection_.partners[row_ends_[b]++] = a;
  }
}

}  // namespace softcd

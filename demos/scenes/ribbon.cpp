#include "scenes/ribbon.hpp"

#include <algorithm>
#include <cmath>

namespace softcd::demo {
namespace {

constexpr int kSamplesPerSpan = 64;
constexpr btScalar kMass = 1;
constexpr btScalar kRibbonMarginInCells = btScalar(0.2);
/// Stiffness of links. With stiffer links the nodes of a tight knot tremble ten times as fast.
constexpr btScalar kRibbonStiffness = btScalar(0.5);
/// With twice as many columns the solver needs four times as many iterations to carry a pull along the ribbon.
constexpr int kColumnsOfAStretch = 75;
constexpr int kFewestIterations = 4;
constexpr btScalar kTaut = btScalar(0.06);  // stretch
constexpr btScalar kGentleStart = 1;        // seconds
const btVector3 kUp(0, 1, 0);

std::vector<btVector3> sample_spline(std::vector<btVector3> points) {
  // One more point beyond each end makes the curve start and end at the given points.
  points.insert(points.begin(), 2 * points[0] - points[1]);
  points.push_back(2 * points.back() - points[points.size() - 2]);
  std::vector<btVector3> samples;
  for (std::size_t span = 0; span + 3 < points.size(); ++span) {
    for (int i = 0; i < kSamplesPerSpan; ++i) {
      const btScalar t = btScalar(i) / kSamplesPerSpan;
      const btScalar s = 1 - t;
      samples.push_back((s * s * s * points[span] + (3 * t * t * t - 6 * t * t + 4) * points[span + 1] +
                         (3 * s * s * s - 6 * s * s + 4) * points[span + 2] + t * t * t * points[span + 3]) /
                        6);
    }
  }
  samples.push_back(points[points.size() - 2]);
  return samples;
}

// Returns points at equal distances along the polyline.
std::vector<btVector3> resample(const std::vector<btVector3>& line, int count, btScalar& length) {
  std::vector<btScalar> lengths = {0};
  for (std::size_t i = 1; i < line.size(); ++i) lengths.push_back(lengths.back() + line[i].distance(line[i - 1]));
  length = lengths.back();
  std::vector<btVector3> points;
  std::size_t i = 0;
  for (int k = 0; k < count; ++k) {
    const btScalar at = length * btScalar(k) / btScalar(count - 1);
    while (i + 2 < lengths.size() && lengths[i + 1] <= at) ++i;
    const btScalar share = std::min((at - lengths[i]) / (lengths[i + 1] - lengths[i]), btScalar(1));
    points.push_back(line[i].lerp(line[i + 1], share));
  }
  return points;
}

}  // namespace

ClothShape ribbon_shape(const std::vector<btVector3>& control_points, btScalar width, int columns) {
  btScalar length = 0;
  const std::vector<btVector3> line = resample(sample_spline(control_points), columns, length);
  std::vector<btVector3> across;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const btVector3 tangent = (line[std::min(i + 1, line.size() - 1)] - line[i == 0 ? 0 : i - 1]).normalized();
    across.push_back((kUp - tangent * kUp.dot(tangent)).normalized());
  }
  ClothShape shape;
  shape.columns = columns;
  shape.rows = std::max(3, static_cast<int>(std::lround(width * btScalar(columns - 1) / length)) + 1);
  shape.position = [=, rows = shape.rows](int column, int row) {
    const auto i = static_cast<std::size_t>(column);
    return line[i] + across[i] * (width * (btScalar(row) / btScalar(rows - 1) - btScalar(0.5)));
  };
  return shape;
}

std::unique_ptr<btSoftBody> make_ribbon(btSoftBodyWorldInfo& world_info, const ClothShape& shape, btScalar friction) {
  auto ribbon = make_cloth(world_info, shape, kMass);
  const btScalar cell = shape.position(0, 0).distance(shape.position(0, 1));
  ribbon->getCollisionShape()->setMargin(kRibbonMarginInCells * cell);
  ribbon->setSelfCollision(true);
  ribbon->m_materials[0]->m_kLST = kRibbonStiffness;
  ribbon->m_cfg.kDF = friction;
  ribbon->m_cfg.kDP = btScalar(0.03);
  const int stretches = shape.columns / kColumnsOfAStretch;
  ribbon->m_cfg.piterations = std::max(kFewestIterations, stretches * stretches);
  return ribbon;
}

StretchGauge::StretchGauge(const btSoftBody& ribbon, int columns, int from_column, int to_column) : ribbon_(&ribbon) {
  const int middle_row = ribbon.m_nodes.size() / columns / 2;
  from_node_ = middle_row * columns + from_column;
  to_node_ = middle_row * columns + to_column;
  for (int i = from_node_; i < to_node_; ++i) length_ += ribbon.m_nodes[i].m_x.distance(ribbon.m_nodes[i + 1].m_x);
}

btScalar StretchGauge::stretch() const {
  return ribbon_->m_nodes[from_node_].m_x.distance(ribbon_->m_nodes[to_node_].m_x) / length_ - 1;
}

btScalar hand_speed(btScalar fastest, btScalar stretch, btScalar time) {
  const btScalar slack = std::clamp(1 - stretch / kTaut, btScalar(0), btScalar(1));
  return fastest * slack * std::min(time / kGentleStart, btScalar(1));
}

}  // namespace softcd::demo

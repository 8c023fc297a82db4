#include "scenes/reef_knot.hpp"

#include <algorithm>

namespace softcd::demo {
namespace {

constexpr btScalar kReefKnotWidth = btScalar(0.35);
constexpr btScalar kReefKnotHeight = btScalar(1.2);
constexpr btScalar kReefKnotLevel = btScalar(0.5);  // of a ribbon's middle above or below the other's where they cross
constexpr btScalar kReefKnotFurthest = btScalar(6.5);
constexpr btScalar kReefKnotPullingSpeed = btScalar(1.5);
constexpr btScalar kReefKnotFriction = btScalar(0.02);

// One half of the ribbon whose ends are on the left, from an end to the middle of its bight, as x, height in levels, z.
// It passes over the other's bight, under the other's leg, round it, and over both its legs.
const btVector3 kHalf[] = {{btScalar(-3.8), 0, btScalar(0.35)},
                           {btScalar(-3.0), 0, btScalar(0.35)},
                           {btScalar(-2.3), 0, btScalar(0.35)},
                           {btScalar(-1.7), 1, btScalar(0.35)},
                           {btScalar(-1.0), 1, btScalar(0.35)},
                           {btScalar(-0.5), 0, btScalar(0.50)},
                           {0, -1, btScalar(0.70)},
                           {btScalar(0.5), 0, btScalar(1.0)},
                           {btScalar(0.95), btScalar(0.7), btScalar(0.9)},
                           {btScalar(1.3), 1, btScalar(0.5)},
                           {btScalar(1.4), 1, 0}};

std::vector<btVector3> control_points(btScalar direction) {
  // The other ribbon is this one, turned by half a turn about the z axis.
  std::vector<btVector3> points;
  for (const btVector3& p : kHalf) points.emplace_back(-direction * p.x(), -direction * kReefKnotLevel * p.y(), p.z());
  for (std::size_t i = points.size() - 1; i-- > 0;) points.emplace_back(points[i].x(), points[i].y(), -points[i].z());
  for (btVector3& p : points) p += btVector3(0, kReefKnotHeight, 0);
  return points;
}

}  // namespace

ReefKnot::ReefKnot(const SceneOptions& options)
    : Scene(options), columns_(options.size), ribbons_{&add_ribbon(-1), &add_ribbon(1)} {
  simulation().world_info().m_gravity.setZero();
}

btSoftBody& ReefKnot::add_ribbon(btScalar direction) {
  ClothShape shape = ribbon_shape(control_points(direction), kReefKnotWidth, columns_);
  const int last = columns_ - 1;
  shape.is_fixed = [last](int column, int) { return column == 0 || column == last; };
  btSoftBody& body = add(make_ribbon(simulation().world_info(), shape, kReefKnotFriction));
  const int leg = columns_ / 10;
  const btVector3 outwards(direction, 0, 0);
  hands_.push_back({&body, 0, outwards, {body, columns_, 0, leg}});
  hands_.push_back({&body, last, outwards, {body, columns_, last - leg, last}});
  return body;
}

void ReefKnot::animate() {
  const bool is_furthest = btFabs(ribbons_[0]->m_nodes[0].m_x.x()) > kReefKnotFurthest;
  const btScalar speed = is_furthest ? btScalar(0) : hand_speed(kReefKnotPullingSpeed, stretch(), time());
  for (const Hand& hand : hands_) {
    for (int node = hand.column; node < hand.ribbon->m_nodes.size(); node += columns_) {
      hand.ribbon->m_nodes[node].m_v = speed * hand.direction;
    }
  }
}

btScalar ReefKnot::overlap() const {
  btScalar left_ribbons_end = -kReefKnotFurthest;
  btScalar right_ribbons_end = kReefKnotFurthest;
  for (int node = 0; node < ribbons_[0]->m_nodes.size(); ++node) {
    left_ribbons_end = std::max(left_ribbons_end, ribbons_[0]->m_nodes[node].m_x.x());
    right_ribbons_end = std::min(right_ribbons_end, ribbons_[1]->m_nodes[node].m_x.x());
  }
  return left_ribbons_end - right_ribbons_end;
}

btScalar ReefKnot::stretch() const {
  btScalar sum = 0;
  for (const Hand& hand : hands_) sum += hand.leg.stretch();
  return sum / btScalar(hands_.size());
}

void ReefKnot::mark_passed_through(const btSoftBody& /*body*/, std::vector<bool>& /*marked*/) const {}

std::vector<Surface> ReefKnot::surfaces() const {
  return {{ribbons_[0], {0.55F, 0.06F, 0.05F}, {0.75F, 0.52F, 0.16F}},
          {ribbons_[1], {0.12F, 0.25F, 0.45F}, {0.35F, 0.55F, 0.50F}}};
}

View ReefKnot::view() const {
  return {btVector3(0, btScalar(5.0), btScalar(5.5)), btVector3(0, btScalar(1.0), btScalar(0.2))};
}

}  // namespace softcd::demo

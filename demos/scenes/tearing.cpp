#include "scenes/tearing.hpp"

#include "apps/tear.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kTearingHeight = 3;
constexpr btScalar kTearingRadius = btScalar(0.6);
constexpr btScalar kSpeed = 3;              // meters a second, downwards
constexpr btScalar kStops = btScalar(1.2);  // seconds
constexpr btScalar kMostStretch = btScalar(1.25);
constexpr btScalar kTearingShortestInCells = btScalar(0.5);

}  // namespace

Tearing::Tearing(const SceneOptions& options)
    : ChangingCloth(options, {4, kTearingHeight, true, btVector3(0, kTearingHeight + kTearingRadius + btScalar(0.3), 0),
                              kTearingRadius}) {}

void Tearing::animate() {
  const btVector3 velocity(0, time() < kStops ? -kSpeed : 0, 0);
  for (int i = 0; i < ball().m_nodes.size(); ++i) ball().m_nodes[i].m_v = velocity;
  ChangingCloth::animate();
}

std::vector<Tearing::Edge> Tearing::edges_to_change() const {
  return overstretched_links(cloth(), kMostStretch, kTearingShortestInCells * spacing());
}

bool Tearing::change_at(const Edge& edge) {
  return cut(cloth(), edge);
}

View Tearing::view() const {
  return {btVector3(btScalar(4.5), btScalar(5.5), btScalar(6.0)), btVector3(0, btScalar(2.2), 0)};
}

}  // namespace softcd::demo

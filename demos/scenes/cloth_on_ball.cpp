#include "scenes/cloth_on_ball.hpp"

#include <algorithm>

#include "scenes/cloth.hpp"
#include "scenes/penetration.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kClothOnBallSide = 6;
constexpr btScalar kClothOnBallRadius = btScalar(1.5);
constexpr btScalar kTurnsFrom = 1;  // seconds
constexpr btScalar kTurnRate = 1;   // radians a second
constexpr btScalar kRampUp = 1;     // seconds until the ball turns at that rate
constexpr btScalar kClothOnBallMarginInCells = btScalar(1) / 4;
const btVector3 kCenter(0, btScalar(2.6), 0);

}  // namespace

ClothOnBall::ClothOnBall(const SceneOptions& options) : Scene(options) {
  const btScalar spacing = kClothOnBallSide / btScalar(options.size - 1);
  const btScalar margin = kClothOnBallMarginInCells * spacing;

  auto cloth =
      make_cloth(simulation().world_info(),
                 horizontal_cloth(options.size, kClothOnBallSide, kCenter.y() + kClothOnBallRadius + 3 * margin), 2);
  cloth->getCollisionShape()->setMargin(margin);
  cloth->setSelfCollision(true);
  cloth->m_cfg.kDF = btScalar(0.4);
  cloth->m_cfg.kDP = btScalar(0.02);
  cloth->m_cfg.piterations = 8;
  cloth_ = &add(std::move(cloth));

  int subdivisions = 1;  // increased until the ball's edges are about as long as the cloth's
  while (kClothOnBallRadius / btScalar(1 << subdivisions) > spacing * btScalar(1.6)) ++subdivisions;
  auto ball = make_ball(simulation().world_info(), kCenter, kClothOnBallRadius, subdivisions);
  ball->getCollisionShape()->setMargin(margin);
  ball->m_cfg.kDF = btScalar(0.4);
  ball_ = &add(std::move(ball));
  ball_at_rest_ = positions_of(*ball_);
}

btScalar ClothOnBall::angle_at(btScalar time) {
  const btScalar t = std::max(btScalar(0), time - kTurnsFrom);
  const btScalar ramp = std::min(t, kRampUp);
  return kTurnRate * (ramp * ramp / (2 * kRampUp) + (t - ramp));
}

void ClothOnBall::animate() {
  const btQuaternion rotation(btVector3(0, 1, 0), angle_at(time() + time_step()));
  std::vector<btVector3> goals;
  goals.reserve(ball_at_rest_.size());
  for (const btVector3& x : ball_at_rest_) goals.push_back(kCenter + quatRotate(rotation, x - kCenter));
  send(*ball_, goals);
}

void ClothOnBall::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  if (&body == cloth_) mark_inside(*ball_, body, marked);
}

std::vector<Surface> ClothOnBall::surfaces() const {
  return {{cloth_, {0.55F, 0.06F, 0.05F}, {0.75F, 0.52F, 0.16F}}, {ball_, {0.12F, 0.25F, 0.45F}, {0.1F, 0.1F, 0.1F}}};
}

View ClothOnBall::view() const {
  return {btVector3(btScalar(5.2), btScalar(5.6), btScalar(7.6)), btVector3(0, btScalar(2.0), 0)};
}

}  // namespace softcd::demo

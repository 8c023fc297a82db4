#include "scenes/changing_cloth.hpp"

#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "scenes/cloth.hpp"
#include "scenes/penetration.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kChangingClothMassPerArea = btScalar(0.1);  // kilograms
constexpr btScalar kChangingClothMarginInCells = btScalar(1) / 8;
constexpr int kStepsBetweenChanges = 4;

/// Makes a cloth with links along faces' edges only, all of which may be changed.
std::unique_ptr<btSoftBody> make_patch(btSoftBodyWorldInfo& world_info, const ClothAndBall& shape, int nodes) {
  const btScalar half = shape.side / 2;
  const auto corner = [&](btScalar x, btScalar z) { return btVector3(x, shape.height, z); };
  const int held = shape.is_held_at_corners ? 1 + 2 + 4 + 8 : 0;
  std::unique_ptr<btSoftBody> cloth(
      btSoftBodyHelpers::CreatePatch(world_info, corner(-half, -half), corner(half, -half), corner(-half, half),
                                     corner(half, half), nodes, nodes, held, /*gendiags=*/true));
  cloth->setTotalMass(kChangingClothMassPerArea * shape.side * shape.side);
  cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  cloth->m_cfg.kDF = btScalar(0.3);
  cloth->m_cfg.kDP = btScalar(0.02);
  cloth->m_cfg.piterations = 8;
  cloth->setSelfCollision(true);
  return cloth;
}

}  // namespace

ChangingCloth::ChangingCloth(const SceneOptions& options, const ClothAndBall& shape)
    : Scene(options), spacing_(shape.side / btScalar(options.size - 1)) {
  const btScalar margin = kChangingClothMarginInCells * spacing_;
  auto cloth = make_patch(simulation().world_info(), shape, options.size);
  cloth->getCollisionShape()->setMargin(margin);
  cloth_ = &add(std::move(cloth));
  auto ball = make_ball(simulation().world_info(), shape.ball_center, shape.ball_radius, /*subdivisions=*/3);
  ball->getCollisionShape()->setMargin(margin);
  ball->m_cfg.kDF = btScalar(0.3);
  ball_ = &add(std::move(ball));
  at_rest_ = positions_of(*cloth_);
}

void ChangingCloth::animate() {
  const int since_change = step_++ % kStepsBetweenChanges;
  if (since_change == 1) restore_lengths_at_rest();
  if (since_change != 0) return;
  for (const Edge& edge : edges_to_change()) change(edge);
}

void ChangingCloth::change(const Edge& edge) {
  if (!change_at(edge)) return;
  changed_.push_back(edge);
  const btVector3 middle = at_rest_[static_cast<std::size_t>(edge.first)].lerp(
      at_rest_[static_cast<std::size_t>(edge.second)], btScalar(0.5));
  at_rest_.resize(static_cast<std::size_t>(cloth_->m_nodes.size()), middle);
}

/// Restores rest lengths: in the step after a change Bullet takes the links' present lengths for them.
void ChangingCloth::restore_lengths_at_rest() {
  const auto at_rest = [&](const btSoftBody::Node* node) {
    return at_rest_[static_cast<std::size_t>(node - &cloth_->m_nodes[0])];
  };
  for (int l = 0; l < cloth_->m_links.size(); ++l) {
    btSoftBody::Link& link = cloth_->m_links[l];
    link.m_rl = at_rest(link.m_n[0]).distance(at_rest(link.m_n[1]));
    link.m_c1 = link.m_rl * link.m_rl;
  }
}

void ChangingCloth::repeat_changes(const Scene& other) {
  const std::vector<Edge>& changed = dynamic_cast<const ChangingCloth&>(other).changed_;
  for (std::size_t i = changed_.size(); i < changed.size(); ++i) change(changed[i]);
  step_ = 0;
}

void ChangingCloth::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  if (&body == cloth_) mark_inside(*ball_, body, marked);
}

std::vector<Surface> ChangingCloth::surfaces() const {
  return {{cloth_, {0.55F, 0.06F, 0.05F}, {0.75F, 0.52F, 0.16F}, /*has_edges_drawn=*/true},
          {ball_, {0.12F, 0.25F, 0.45F}, {0.1F, 0.1F, 0.1F}}};
}

}  // namespace softcd::demo

#include "scenes/bowline.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kBowlineWidth = btScalar(0.35);
constexpr btScalar kBowlineHeight = btScalar(1.5);
constexpr btScalar kBowlineLevel = btScalar(0.6);  // between parts of the ribbon that cross
constexpr btScalar kBowlineFurthest = 16;
constexpr btScalar kBowlinePullingSpeed = 3;
constexpr btScalar kBowlineFriction = btScalar(0.8);
constexpr btScalar kPostRadius = btScalar(0.6);
constexpr btScalar kPostHeight = 3;
const btVector3 kPostFoot(btScalar(-3.5), 0, 0);

// The path from the end of the standing part to the free end, as x, height in levels, z. The ribbon's bight is level;
// one of its legs comes from the post, the other leg is the free end. The standing part comes up through the bight and
// goes round both its legs. It then passes under itself and becomes the other side of the loop round the post.
const double kPath[][3] = {
    {4.2, 0, 0},        {3.4, 0, 0},         {2.7, -0.3, 0},     {2.2, -1.2, 0},   {1.8, -1.1, 0},    {1.35, 0.3, 0},
    {1.0, 1.7, 0.05},   {0.65, 2.2, 0.1},    {0.3, 1.9, 0.3},    {0.0, 1.3, 0.65}, {-0.2, 0, 1.05},   {-0.2, -1.2, 0.8},
    {-0.12, -1.3, 0.3}, {-0.05, -1.3, -0.3}, {0.02, -1.2, -0.8}, {0.1, 0, -1.1},   {0.25, 1.2, -0.8}, {0.4, 0.9, -0.35},
    {0.6, 0.6, 0.05},   {0.8, 0.9, 0.4},     {0.95, 1.2, 0.75},  {0.9, 0.6, 1.2},  {0.5, 0, 1.5},     {-0.3, 0, 1.55},
    {-1.3, 0, 1.4},     {-2.3, 0, 1.2},      {-3.4, 0, 1.0},     {-4.2, 0, 0.75},  {-4.5, 0, 0},      {-4.2, 0, -0.75},
    {-3.4, 0, -1.0},    {-2.5, 0, -0.9},     {-1.5, 0, -0.65},   {-0.5, 0, -0.5},  {0.3, 0, -0.5},    {1.1, 0, -0.5},
    {1.7, 0, -0.45},    {2.05, 0, -0.2},     {2.05, 0, 0.2},     {1.7, 0, 0.45},   {1.1, 0, 0.5},     {0.3, 0, 0.5},
    {-0.5, 0, 0.5},     {-1.3, 0, 0.5},      {-2.0, 0, 0.5},     {-3.0, 0, 0.4}};

std::vector<btVector3> control_points() {
  std::vector<btVector3> points;
  for (const auto& [x, level, z] : kPath) {
    points.emplace_back(btScalar(x), kBowlineHeight + kBowlineLevel * btScalar(level), btScalar(z));
  }
  return points;
}

}  // namespace

Bowline::Bowline(const SceneOptions& options) : Scene(options), columns_(options.size) {
  simulation().world_info().m_gravity.setZero();
  ClothShape shape = ribbon_shape(control_points(), kBowlineWidth, columns_);
  shape.is_fixed = [](int column, int) { return column == 0; };
  ribbon_ = &add(make_ribbon(simulation().world_info(), shape, kBowlineFriction));
  standing_part_.emplace(*ribbon_, columns_, 0, columns_ / 20);

  const btScalar spacing = kBowlineWidth / btScalar(shape.rows - 1);
  const int around = 2 * static_cast<int>(SIMD_PI * kPostRadius / (2 * spacing));
  const int along = static_cast<int>(kPostHeight / (2 * spacing));
  ClothShape tube = vertical_tube(kPostFoot, kPostRadius, kPostHeight, around, along);
  tube.is_fixed = [](int, int) { return true; };
  auto post = make_cloth(simulation().world_info(), tube, 1);
  post->getCollisionShape()->setMargin(ribbon_->getCollisionShape()->getMargin());
  post->m_cfg.kDF = kBowlineFriction;
  post_ = &add(std::move(post));
}

void Bowline::animate() {
  const bool is_furthest = standing_end() > kBowlineFurthest;
  const btScalar speed = is_furthest ? btScalar(0) : hand_speed(kBowlinePullingSpeed, stretch(), time());
  for (int node = 0; node < ribbon_->m_nodes.size(); node += columns_) {
    ribbon_->m_nodes[node].m_v = btVector3(speed, 0, 0);
  }
}

btScalar Bowline::standing_end() const {
  return ribbon_->m_nodes[0].m_x.x();
}

btScalar Bowline::free_end() const {
  return ribbon_->m_nodes[columns_ - 1].m_x.x();
}

void Bowline::mark_passed_through(const btSoftBody& /*body*/, std::vector<bool>& /*marked*/) const {}

std::vector<Surface> Bowline::surfaces() const {
  return {{ribbon_, {0.10F, 0.32F, 0.22F}, {0.65F, 0.45F, 0.12F}}, {post_, {0.12F, 0.25F, 0.45F}, {0.1F, 0.1F, 0.1F}}};
}

View Bowline::view() const {
  return {btVector3(btScalar(0.5), btScalar(8.0), btScalar(7.5)),
          btVector3(btScalar(0.5), btScalar(1.2), btScalar(0.2))};
}

}  // namespace softcd::demo

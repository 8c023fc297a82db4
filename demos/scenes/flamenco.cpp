#include "scenes/flamenco.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "scenes/cloth.hpp"
#include "scenes/penetration.hpp"
#include "scenes/surface_mesh.hpp"

namespace softcd::demo {
namespace {

// Metres, from the feet to the head.
const std::vector<ProfilePoint> kDancer = {{0, btScalar(0.04)},
                                           {btScalar(0.10), btScalar(0.04)},
                                           {btScalar(0.095), btScalar(0.25)},
                                           {btScalar(0.115), btScalar(0.50)},
                                           {btScalar(0.16), btScalar(0.72)},
                                           {btScalar(0.18), btScalar(0.86)},
                                           {btScalar(0.165), btScalar(0.95)},
                                           {btScalar(0.115), btScalar(1.08)},
                                           {btScalar(0.13), btScalar(1.20)},
                                           {btScalar(0.15), btScalar(1.32)},
                                           {btScalar(0.12), btScalar(1.40)},
                                           {btScalar(0.05), btScalar(1.44)},
                                           {btScalar(0.048), btScalar(1.50)},
                                           {btScalar(0.08), btScalar(1.56)},
                                           {btScalar(0.09), btScalar(1.63)},
                                           {btScalar(0.07), btScalar(1.70)},
                                           {0, btScalar(1.74)}};
constexpr btScalar kWaistHeight = btScalar(1.08);
constexpr btScalar kWaistRadius = btScalar(0.125);
constexpr btScalar kFlamencoLayerGap = btScalar(0.012);  // at the waist
constexpr btScalar kRuffles = 10;
constexpr btScalar kRuffleDepth = btScalar(0.07);  // of the hem's radius

struct Layer {
  btScalar hem_height;
  btScalar slope;  ///< radius over depth below the waist
  Color front, back;
};

const std::array<Layer, 3> kLayers = {{{btScalar(0.16), btScalar(0.52), {0.60F, 0.50F, 0.42F}, {0.35F, 0.28F, 0.22F}},
                                       {btScalar(0.40), btScalar(0.66), {0.05F, 0.05F, 0.06F}, {0.10F, 0.08F, 0.08F}},
                                       {btScalar(0.62), btScalar(0.84), {0.62F, 0.04F, 0.05F}, {0.40F, 0.05F, 0.05F}}}};
constexpr btScalar kLongest = btScalar(0.9);  // a layer's slant length, from which cells are sized
constexpr btScalar kColumnsPerRow = 3;

// The dance: amplitude and period in seconds.
struct Swing {
  btScalar amplitude;
  btScalar period;
};

constexpr Swing kFlamencoTurn = {5, 3};  // radians
constexpr Swing kSwayX = {btScalar(0.12), btScalar(3.3)};
constexpr Swing kSwayZ = {btScalar(0.08), btScalar(2.1)};
constexpr Swing kLegs = {btScalar(0.14), btScalar(1.5)};
constexpr btScalar kLegsBelow = btScalar(0.8);

/// Returns the angle or offset at a time; 0 and at rest at first.
btScalar swing(const Swing& swing, btScalar time) {
  return swing.amplitude * (1 - btCos(SIMD_2_PI * time / swing.period)) / 2;
}

}  // namespace

btVector3 Flamenco::pose(const btVector3& at_rest, btScalar time) {
  btVector3 x = at_rest;
  const btScalar below = std::max(btScalar(0), (kLegsBelow - x.y()) / kLegsBelow);
  x.setX(x.x() + swing(kLegs, time) * below * below);
  const btVector3 turned = quatRotate(btQuaternion(btVector3(0, 1, 0), swing(kFlamencoTurn, time)), x);
  return turned + btVector3(swing(kSwayX, time), 0, swing(kSwayZ, time));
}

Flamenco::Flamenco(const SceneOptions& options) : Scene(options) {
  columns_ = 2 * static_cast<int>(kColumnsPerRow * btScalar(options.size) / 2);
  const btScalar spacing_at_waist = SIMD_2_PI * kWaistRadius / btScalar(columns_);
  const btScalar margin = std::min(spacing_at_waist, kFlamencoLayerGap) / 4;
  add_dancer(kLongest / btScalar(options.size), margin);
  for (int layer = 0; layer < static_cast<int>(kLayers.size()); ++layer) {
    add_layer(layer, options.size, columns_, margin);
  }
}

void Flamenco::add_dancer(btScalar spacing, btScalar margin) {
  const int segments = std::max(16, columns_ / 2);
  auto dancer = make_body(simulation().world_info(), lathe_mesh(refined(kDancer, spacing), segments), 0);
  dancer->getCollisionShape()->setMargin(margin);
  dancer->m_cfg.kDF = btScalar(0.2);
  dancer_ = &add(std::move(dancer));
  dancer_at_rest_ = positions_of(*dancer_);
}

void Flamenco::add_layer(int layer, int rows, int columns, btScalar margin) {
  const auto& [hem_height, slope, front, back] = kLayers[static_cast<std::size_t>(layer)];
  ClothShape shape;
  shape.is_closed = true;
  shape.columns = columns;
  shape.rows = std::max(4, static_cast<int>(btScalar(rows) * (kWaistHeight - hem_height) / kLongest)) + 1;
  shape.position = [=, slope = slope, hem_height = hem_height](int column, int row) {
    const btScalar down = btScalar(row) / btScalar(shape.rows - 1);
    const btScalar angle = SIMD_2_PI * btScalar(column) / btScalar(columns);
    const btScalar depth = down * (kWaistHeight - hem_height);
    const btScalar cone = kWaistRadius + kFlamencoLayerGap * btScalar(layer) + slope * depth;
    const btScalar radius = cone * (1 + kRuffleDepth * down * btCos(kRuffles * angle));
    return btVector3(radius * btCos(angle), kWaistHeight - depth, radius * btSin(angle));
  };
  shape.is_fixed = [](int, int row) { return row == 0; };
  auto cloth = make_cloth(simulation().world_info(), shape, 1);
  cloth->getCollisionShape()->setMargin(margin);
  cloth->setSelfCollision(true);
  cloth->m_cfg.kDF = btScalar(0.2);
  cloth->m_cfg.kDP = btScalar(0.02);
  // With fewer iterations, fine cloths stretch, wind themselves up and are torn.
  cloth->m_cfg.piterations = std::max(8, rows / 2);
  layers_.push_back(&add(std::move(cloth)));
  std::vector<btVector3> waist = positions_of(*layers_.back());
  waist.resize(static_cast<std::size_t>(columns));
  waists_at_rest_.push_back(std::move(waist));
}

void Flamenco::animate() {
  const auto goals = [this](const std::vector<btVector3>& at_rest) {
    std::vector<btVector3> positions;
    positions.reserve(at_rest.size());
    for (const btVector3& x : at_rest) positions.push_back(pose(x, time() + time_step()));
    return positions;
  };
  send(*dancer_, goals(dancer_at_rest_));
  for (std::size_t i = 0; i < layers_.size(); ++i) send(*layers_[i], goals(waists_at_rest_[i]));
}

void Flamenco::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  if (&body != dancer_) mark_inside(*dancer_, body, marked);
}

std::vector<Surface> Flamenco::surfaces() const {
  std::vector<Surface> surfaces = {{dancer_, {0.48F, 0.26F, 0.16F}, {0.1F, 0.1F, 0.1F}}};
  for (std::size_t i = 0; i < layers_.size(); ++i) surfaces.push_back({layers_[i], kLayers[i].front, kLayers[i].back});
  return surfaces;
}

View Flamenco::view() const {
  return {btVector3(btScalar(1.4), btScalar(1.7), btScalar(3.0)), btVector3(btScalar(0.05), btScalar(0.8), 0)};
}

}  // namespace softcd::demo

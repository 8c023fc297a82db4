#include "scenes/two_cloths.hpp"

#include <utility>

#include "scenes/cloth.hpp"

namespace softcd::demo {
namespace {

constexpr btScalar kSide = 6;
constexpr btScalar kHeight = 3;
constexpr btScalar kDrop = btScalar(0.3);
constexpr btScalar kTurn = btScalar(0.35);  // radians

std::unique_ptr<btSoftBody> make_configured(btSoftBodyWorldInfo& world_info, const ClothShape& shape) {
  auto cloth = make_cloth(world_info, shape, 2);
  cloth->getCollisionShape()->setMargin(kSide / btScalar(shape.columns - 1) / 4);
  cloth->m_cfg.kDF = btScalar(0.5);
  cloth->m_cfg.kDP = btScalar(0.01);
  cloth->m_cfg.piterations = 4;
  return cloth;
}

// Whether `point` is vertically below one of the cloth's triangles.
bool is_below(const btSoftBody& cloth, const btVector3& point) {
  for (int f = 0; f < cloth.m_faces.size(); ++f) {
    const btSoftBody::Face& face = cloth.m_faces[f];
    const btVector3& a = face.m_n[0]->m_x;
    const btVector3& b = face.m_n[1]->m_x;
    const btVector3& c = face.m_n[2]->m_x;
    const auto area = [](const btVector3& p, const btVector3& q, const btVector3& r) {
      return (q.x() - p.x()) * (r.z() - p.z()) - (q.z() - p.z()) * (r.x() - p.x());
    };
    const btScalar whole = area(a, b, c);
    if (whole == 0) continue;
    const btScalar u = area(point, b, c) / whole;
    const btScalar v = area(a, point, c) / whole;
    if (u < 0 || v < 0 || u + v > 1) continue;
    if (point.y() < u * a.y() + v * b.y() + (1 - u - v) * c.y()) return true;
  }
  return false;
}

}  // namespace

LowerAndUpperCloth make_two_cloths(btSoftBodyWorldInfo& world_info, int nodes_per_side) {
  const int last = nodes_per_side - 1;
  ClothShape held = horizontal_cloth(nodes_per_side, kSide, kHeight);
  held.is_fixed = [last](int column, int row) { return column == 0 || row == 0 || column == last || row == last; };
  auto falling = make_configured(world_info, horizontal_cloth(nodes_per_side, kSide, kHeight + kDrop));
  falling->rotate(btQuaternion(btVector3(0, 1, 0), kTurn));
  return {make_configured(world_info, held), std::move(falling)};
}

TwoCloths::TwoCloths(const SceneOptions& options) : Scene(options) {
  LowerAndUpperCloth cloths = make_two_cloths(simulation().world_info(), options.size);
  lower_ = &add(std::move(cloths.lower));
  upper_ = &add(std::move(cloths.upper));
}

void TwoCloths::mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const {
  if (&body != upper_) return;
  btVector3 low, high;
  lower_->getAabb(low, high);
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& x = body.m_nodes[i].m_x;
    if (x.y() < high.y() && is_below(*lower_, x)) marked[static_cast<std::size_t>(i)] = true;
  }
}

std::vector<Surface> TwoCloths::surfaces() const {
  return {{lower_, {0.10F, 0.28F, 0.42F}, {0.35F, 0.42F, 0.45F}}, {upper_, {0.60F, 0.30F, 0.05F}, {0.5F, 0.1F, 0.1F}}};
}

View TwoCloths::view() const {
  return {btVector3(btScalar(5.5), btScalar(6.5), btScalar(8)), btVector3(0, btScalar(2.2), 0)};
}

}  // namespace softcd::demo

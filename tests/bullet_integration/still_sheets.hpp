#pragma once

#include <set>
#include <utility>
#include <vector>

#include "random.hpp"
#include "soft_body_support.hpp"

/// Sheets in given places, for tests of the contacts that Settings::contacts chooses, and the features of contacts.
namespace softcd::test {

using bullet::Contacts;
using demo::PlugIn;
using demo::Simulation;
using SContact = btSoftBody::SContact;

inline constexpr btScalar kThickness = btScalar(0.05);
inline constexpr btScalar kCell = btScalar(0.125);
inline constexpr int kNodes = 9;  // a side of a sheet
inline constexpr long double kRounding = 2e-6L;

inline bullet::Settings settings_choosing(Contacts contacts, std::uint32_t per_node = 0) {
  bullet::Settings settings = test_settings();
  settings.contacts = contacts;
  settings.contacts_per_node = per_node;
  settings.untangle = bullet::Untangle::later;  // sheets of tests start through each other
  return settings;
}

/// Bodies that stay where they are put: nothing pulls at them, and Bullet does not solve their contacts.
class Still {
 public:
  explicit Still(const bullet::Settings& settings, PlugIn plug_in = PlugIn::one_line_world)
      : simulation_(plug_in, settings) {
    simulation_.world_info().m_gravity.setZero();
  }

  btSoftBody& add(const demo::ClothShape& shape) {
    auto sheet = demo::make_cloth(simulation_.world_info(), shape, 1);
    sheet->getCollisionShape()->setMargin(kThickness);
    sheet->m_cfg.piterations = 0;
    sheet->m_cfg.kDF = btScalar(0.25);
    bodies_.push_back(&simulation_.add(std::move(sheet)));
    return *bodies_.back();
  }
  void step() { simulation_.step(kStep); }

  Simulation& simulation() { return simulation_; }
  const std::vector<btSoftBody*>& bodies() const { return bodies_; }

 private:
  Simulation simulation_;
  std::vector<btSoftBody*> bodies_;
};

inline demo::ClothShape flat(btScalar height, btScalar shift = 0) {
  demo::ClothShape shape;
  shape.columns = shape.rows = kNodes;
  shape.position = [=](int column, int row) {
    return btVector3(kCell * btScalar(column) + shift, height, kCell * btScalar(row) + shift);
  };
  return shape;
}

/// Each node off its place by up to `most` along every axis.
inline demo::ClothShape bumpy(btScalar height, btScalar most, Random& random) {
  demo::ClothShape shape = flat(height);
  btAlignedObjectArray<btVector3> offsets;
  for (int i = 0; i < kNodes * kNodes; ++i) {
    const auto offset = [&] { return btScalar(random.uniform(double(-most), double(most))); };
    offsets.push_back(btVector3{offset(), offset(), offset()});
  }
  shape.position = [=, on = shape.position](int column, int row) {
    return on(column, row) + offsets[row * kNodes + column];
  };
  return shape;
}

/// Two layers of one body at heights 0 and `gap`, joined along x = 0.
inline demo::ClothShape folded(btScalar gap) {
  demo::ClothShape shape;
  shape.columns = 2 * kNodes;
  shape.rows = kNodes;
  shape.position = [=](int column, int row) {
    const bool is_lower = column < kNodes;
    const int from_bend = is_lower ? kNodes - 1 - column : column - kNodes;
    return btVector3(kCell * btScalar(from_bend), is_lower ? 0 : gap, kCell * btScalar(row));
  };
  return shape;
}

using Feature = std::set<const btSoftBody::Node*>;

/// The nodes of the smallest feature with the contact's point.
inline Feature feature_of(const SContact& contact) {
  Feature feature;
  for (int i = 0; i < 3; ++i) {
    if (contact.m_weights[i] > 0) feature.insert(contact.m_face->m_n[i]);
  }
  return feature;
}

inline bool has(const btSoftBody::Face& face, const Feature& feature) {
  return std::all_of(feature.begin(), feature.end(), [&](const btSoftBody::Node* node) {
    return node == face.m_n[0] || node == face.m_n[1] || node == face.m_n[2];
  });
}

}  // namespace softcd::test

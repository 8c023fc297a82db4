#pragma once

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"
#include "soft_body_support.hpp"

namespace softcd::test {

/// Two sheets, one close above the other, held in the air.
class TwoSheets {
 public:
  explicit TwoSheets(demo::PlugIn plug_in, const bullet::Settings& settings = test_settings())
      : simulation_(plug_in, settings) {
    simulation_.world_info().m_gravity.setZero();
  }

  void add(int group_a = 1, int mask_a = -1, int group_b = 1, int mask_b = -1) {
    SheetOptions options;
    options.margin = btScalar(0.02);
    lower_ = &simulation_.add(make_sheet(simulation_.world_info(), options), group_a, mask_a);
    options.height = btScalar(0.03);
    upper_ = &simulation_.add(make_sheet(simulation_.world_info(), options), group_b, mask_b);
    for (btSoftBody* body : {lower_, upper_}) body->m_cfg.piterations = 0;
  }

  /// Contacts between the sheets after one more step.
  int step() {
    simulation_.step(kStep);
    return lower_->m_scontacts.size() + upper_->m_scontacts.size();
  }

  demo::Simulation& simulation() { return simulation_; }
  btOverlappingPairCache& pair_cache() { return *simulation_.world().getPairCache(); }
  btSoftBody& lower() { return *lower_; }
  btSoftBody& upper() { return *upper_; }

 private:
  demo::Simulation simulation_;
  btSoftBody* lower_ = nullptr;
  btSoftBody* upper_ = nullptr;
};

/// A cloth that falls the last bit onto a sheet with fixed nodes.
struct ClothOnSheet {
  demo::Simulation simulation;
  btSoftBody* sheet;
  btSoftBody* cloth;

  explicit ClothOnSheet(demo::PlugIn plug_in, const bullet::Settings& settings = test_settings())
      : simulation(plug_in, settings) {
    SheetOptions options;
    options.fixed = true;
    sheet = &simulation.add(make_sheet(simulation.world_info(), options));
    options.fixed = false;
    options.height = btScalar(0.11);
    options.side = btScalar(0.8);
    cloth = &simulation.add(make_sheet(simulation.world_info(), options));
  }

  void run(int steps) {
    for (int i = 0; i < steps; ++i) simulation.step(kStep);
  }
};

/// Every coordinate of every node.
inline std::vector<btScalar> coordinates_of(const btSoftBody& body) {
  std::vector<btScalar> coordinates;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& x = body.m_nodes[i].m_x;
    coordinates.insert(coordinates.end(), {x.x(), x.y(), x.z()});
  }
  return coordinates;
}

inline void append(std::vector<btScalar>& values, const std::vector<btScalar>& more) {
  values.insert(values.end(), more.begin(), more.end());
}

/// Two clustered balls that overlap each other and, by a little, a box below them; one metre across, five metres aside.
struct ClusteredBalls {
  btSoftBody* balls[2];

  ClusteredBalls(demo::Simulation& simulation, int flags) {
    simulation.add_static_box(btVector3(1, 1, 1), btVector3(5, btScalar(-1.45), 0));
    for (int b = 0; b < 2; ++b) {
      const btVector3 center(5 + btScalar(b) * btScalar(0.9), 0, 0);
      auto ball = demo::make_ball(simulation.world_info(), center, btScalar(0.5), 2);
      ball->setTotalMass(1, /*fromfaces=*/true);
      ball->generateClusters(8);
      ball->m_cfg.collisions = flags;
      balls[b] = &simulation.add(std::move(ball));
    }
  }
};

}  // namespace softcd::test

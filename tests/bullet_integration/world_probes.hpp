#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "any_simulation.hpp"
#include "random.hpp"
#include "scenes/vectors.hpp"
#include "softcd/bullet/world_probe.hpp"

namespace softcd::test {

inline Vec3d node(const btSoftBody& body, std::uint32_t i) {
  const btVector3& x = body.m_nodes[int(i)].m_x;
  return demo::to_vec3d(x);
}

inline std::vector<Triangle> faces_of(const btSoftBody& body) {
  std::vector<Triangle> faces;
  for (int i = 0; i < body.m_faces.size(); ++i) {
    Triangle face{};
    for (int k = 0; k < 3; ++k) face.v[k] = std::uint32_t(body.m_faces[i].m_n[k] - &body.m_nodes[0]);
    faces.push_back(face);
  }
  return faces;
}

/// Softcd's worlds, and one that knows nothing of it.
class WorldProbes : public testing::TestWithParam<std::optional<World>> {
 protected:
  AnySimulation simulation{GetParam().value_or(World::one_line),
                           GetParam().has_value() ? std::optional(cpu_settings()) : std::nullopt};
  bullet::WorldProbe probe{simulation.world()};

  btSoftBody& add_ball(const btVector3& center) {
    btSoftBody& ball = simulation.add(demo::make_ball(simulation.world_info(), center, btScalar(0.5), 1));
    ball.getCollisionShape()->setMargin(btScalar(0.03));
    // Moves nodes as an app may do.
    Random random(std::uint64_t(ball.m_nodes.size()) + std::uint64_t(simulation.world().getNumCollisionObjects()));
    for (int i = 0; i < ball.m_nodes.size(); ++i) {
      const Vec3d by = random.in_box(0.05);
      ball.m_nodes[i].m_x += btVector3(btScalar(by.x), btScalar(by.y), btScalar(by.z));
    }
    return ball;
  }
};
inline const auto kProbedWorlds = testing::Values(std::nullopt, World::one_line, World::multi_body, World::dispatcher,
                                                  World::deformable, World::attached, World::attached_deformable);

inline std::string name_of_probed(const testing::TestParamInfo<std::optional<World>>& world) {
  return world.param ? name_of(*world.param) : std::string("bullets");
}

}  // namespace softcd::test

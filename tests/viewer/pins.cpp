#include "viewer/pins.hpp"

#include <gtest/gtest.h>

#include "softcd/core/vec3.hpp"

namespace softcd::demo {
namespace {

TEST(Pins, stand_at_nodes_that_hold_a_body) {
  btSoftBodyWorldInfo world_info;
  const btVector3 corners[] = {{0, 2, 0}, {1, 2, 0}, {0, 2, 1}};
  btSoftBody cloth(&world_info, 3, corners, nullptr);
  for (int i = 0; i < 3; ++i) cloth.appendLink(i, (i + 1) % 3);
  EXPECT_TRUE(pins_of(cloth).empty()) << "nothing holds it";
  cloth.setMass(0, 0);
  const std::vector<PinCorner> pin = pins_of(cloth);
  ASSERT_EQ(pin.size(), 24U);
  for (std::size_t i = 0; i < pin.size(); i += 3) {
    const Vec3f across = cross(pin[i + 1].position - pin[i].position, pin[i + 2].position - pin[i].position);
    EXPECT_GT(dot(across, pin[i].normal), 0) << "seen from outside";
    EXPECT_LT(squared_norm(pin[i].position - Vec3f{0, 2, 0}), 0.5F);
  }
  for (int i = 1; i < 3; ++i) cloth.setMass(i, 0);
  EXPECT_TRUE(pins_of(cloth).empty()) << "it is moved as a whole";
}

}  // namespace
}  // namespace softcd::demo

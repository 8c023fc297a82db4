#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "any_simulation.hpp"
#include "scenes/penetration.hpp"

namespace softcd::test {

/// A world without gravity, and its warnings.
class WarnedSimulation : public testing::TestWithParam<World> {
 protected:
  explicit WarnedSimulation(const bullet::Settings& settings = careful_settings())
      : simulation(GetParam(), with_log(settings)) {
    simulation.set_gravity(btVector3(0, 0, 0));
  }

  /// Counts edges of one body in triangles of another. No body here asks for contacts within itself.
  static std::size_t count_edges(const std::vector<const btSoftBody*>& bodies) {
    return demo::find_intersections(bodies, [](const btSoftBody& a, const btSoftBody& b) { return &a != &b; })
        .edge_count;
  }

  std::vector<std::string> warnings;
  AnySimulation simulation;

 private:
  bullet::Settings with_log(bullet::Settings settings) {
    settings.log = [this](LogLevel level, std::string_view text) {
      if (level == LogLevel::warning) warnings.emplace_back(text);
    };
    return settings;
  }
};

}  // namespace softcd::test

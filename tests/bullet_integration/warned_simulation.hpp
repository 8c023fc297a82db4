#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "any_simulation.hpp"

namespace softcd::test {

/// A world without gravity in which nothing passes through anything, and what it warns of.
class WarnedSimulation : public testing::TestWithParam<World> {
 protected:
  WarnedSimulation() : simulation(GetParam(), settings()) { simulation.world_info().m_gravity.setZero(); }

  std::vector<std::string> warnings;
  AnySimulation simulation;

 private:
  bullet::Settings settings() {
    bullet::Settings settings = cpu_settings(Detection::ccd);
    settings.edge_contacts = bullet::EdgeContacts::respond;
    settings.log = [this](LogLevel level, std::string_view text) {
      if (level == LogLevel::warning) warnings.emplace_back(text);
    };
    return settings;
  }
};

}  // namespace softcd::test

// The time that softcd saves in a world's first step.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <limits>

#include "soft_body_support.hpp"

namespace softcd::test {
namespace {

using demo::PlugIn;
using demo::Simulation;

class FirstStep : public testing::TestWithParam<PlugIn> {};
INSTANTIATE_TEST_SUITE_P(PlugIns, FirstStep, testing::ValuesIn(kPlugIns), plug_in_name);

/// Returns processor time, because the machine may have other work.
double milliseconds_of_step(Simulation& simulation) {
  const std::clock_t start = std::clock();
  simulation.step(kStep);
  return 1000.0 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

// Bullet's first step builds the face tree in time quadratic in the faces.
TEST_P(FirstStep, costs_no_more_than_three_later_ones) {
  double first = std::numeric_limits<double>::max();
  double later = first;
  for (int attempt = 0; attempt < 3; ++attempt) {
    Simulation simulation(GetParam(), cpu_settings());
    SheetOptions options;
    options.nodes_per_side = 51;
    options.side = 3;
    options.margin = btScalar(0.02);
    simulation.add(make_sheet(simulation.world_info(), options));
    options.height = btScalar(0.03);
    simulation.add(make_sheet(simulation.world_info(), options));
    first = std::min(first, milliseconds_of_step(simulation));
    for (int step = 0; step < 5; ++step) later = std::min(later, milliseconds_of_step(simulation));
  }
  std::printf("2 x 5000 faces: first step %.2f ms, later %.2f ms\n", first, later);
  EXPECT_LT(first, 3 * later);
}

}  // namespace
}  // namespace softcd::test

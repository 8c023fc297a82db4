// A long simulation in which all kinds of things change. tests/soak.sh has the long form.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "soaked_world.hpp"
#include "softcd/pipeline/detector.hpp"

namespace softcd::test {
namespace {

/// Returns the number in the environment variable, or that of the ordinary tests.
std::uint64_t number(const char* name, std::uint64_t of_tests) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::stoull(text) : of_tests;
}

/// In MiB.
double resident_set() {
  std::ifstream file("/proc/self/statm");
  double pages = 0;
  double resident_pages = 0;
  file >> pages >> resident_pages;
  return resident_pages * 4096 / (1 << 20);
}

/// In MiB. A world may add this to what the process has before; 20,000 steps were seen to add 12 to 21.
constexpr double kMostOfAWorld = 48;

/// The CUDA driver maps its libraries when a device is used for the first time, which may be in any step.
void use_device_once() {
  if (*cuda_problem() != '\0') return;
  SceneOptions options;
  options.backend = Backend::cuda;
  Scene scene(options);
  const Triangle triangle{{0, 1, 2}};
  const std::vector<Vec3f> x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (int i = 0; i < 2; ++i) scene.set_positions(scene.add_body({{&triangle, 1}, 3, {}}), x);
  Query(scene).detect();
}

class Soak : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, Soak, kWorlds, world_name);

TEST_P(Soak, nothing_passes_through_anything_and_memory_does_not_grow) {
  const std::uint64_t steps = number("SOFTCD_SOAK_STEPS", 300);
  const std::uint64_t number_of_run = number("SOFTCD_SOAK_RUN", 1);
  use_device_once();
  const double before = resident_set();
  SoakedWorld world(GetParam(), number_of_run);
  double most = 0;
  double most_of_first_quarter = 0;
  for (std::uint64_t i = 0; i < steps; ++i) {
    const std::string fault = world.step();
    ASSERT_EQ(fault, "") << "in step " << i << " of run " << number_of_run;
    if (i % 64 == 0) most = std::max(most, resident_set());
    if (i <= steps / 4) most_of_first_quarter = most;
  }
  const SoakCounts& counts = world.counts();
  std::cout << counts.steps << " steps, " << counts.watched_steps << " of them watched: " << counts.came
            << " bodies came, " << counts.went << " went, " << counts.torn_links << " links torn, "
            << counts.refinements << " refinements, " << counts.settings << " settings, " << counts.contacts
            << " contacts, " << counts.impacts << " impacts, " << counts.held_nodes << " nodes held, " << counts.excused
            << " steps excused, " << counts.peak_bytes << " bytes at most, resident set " << before << " MiB before, "
            << most_of_first_quarter << " in the first quarter, " << most << " in all\n";
#ifndef __SANITIZE_ADDRESS__  // which keeps freed memory, a varying amount of it
  EXPECT_LT(most, most_of_first_quarter * 1.1 + 16);
  EXPECT_LT(most, before + kMostOfAWorld);
#endif
  EXPECT_LT(counts.peak_bytes, 64U << 20);
  EXPECT_GT(counts.contacts, steps / 10);
  EXPECT_TRUE(GetParam() == World::dispatcher || counts.watched_steps > steps / 3);
}

}  // namespace
}  // namespace softcd::test

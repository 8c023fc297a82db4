#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "scenes/scene.hpp"

namespace softcd::benchmarks {

enum class SceneSize : std::uint32_t { smallest, usual, papers };

struct CrossingsOptions {
  std::vector<std::string> scenes;  ///< empty: all
  std::vector<demo::World> worlds = {demo::World::classic, demo::World::deformable};
  std::vector<int> steps_per_second = {30, 60, 120, 240};
  double seconds = 2.5;
  double time_limit = std::numeric_limits<double>::infinity();  ///< of the machine's time, for each run
  SceneSize size = SceneSize::smallest;
  bullet::Contacts contacts = bullet::Contacts::all;
  Backend backend = Backend::automatic;
  std::string machine;        ///< empty: the processor
  std::string markdown_file;  ///< empty: none
  std::string json_file;      ///< empty: none
};

/// Adds the subcommand `crossings`, which fills `options` and then runs the benchmark.
void add_crossings(CLI::App& app, CrossingsOptions& options);

}  // namespace softcd::benchmarks

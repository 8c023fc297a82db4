#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "scenes/scene.hpp"

namespace softcd::benchmarks {

struct SimulatedScenesOptions {
  std::vector<std::string> scenes;  ///< empty: all
  demo::World world = demo::World::classic;
  bool papers_sizes = true;
  long steps = 600;
  int samples = 8;
  std::vector<Backend> backends = {Backend::automatic};
  int repetitions = 20;
  double most_tests = 2e10;
  std::string machine;        ///< empty: the processor
  std::string markdown_file;  ///< empty: none
  std::string json_file;      ///< empty: none
  std::string csv_file;       ///< empty: none
};

/// Adds the subcommand `scenes`, which fills `options` and then runs the benchmark.
void add_simulated_scenes(CLI::App& app, SimulatedScenesOptions& options);

}  // namespace softcd::benchmarks

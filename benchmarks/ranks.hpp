#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "detector.hpp"

namespace softcd::benchmarks {

struct RankOptions {
  std::vector<int> ranks = {1, 2};
  std::vector<double> triangles = {1e6, 1e7};
  std::vector<std::string> step_folders;  ///< measured too
  std::vector<Mode> modes = {kDiscreteFast, kContinuousPrecise};
  Backend backend = Backend::cuda;
  bool is_weak = false;  ///< the number of triangles is for each rank instead of for all together
  int repetitions = 20;
  std::string machine;                   ///< empty: the processor
  std::string markdown_file, json_file;  ///< empty: none
};

/// Adds the subcommand `scaling`, which fills `options` and then runs the benchmark.
void add_ranks(CLI::App& app, RankOptions& options);

}  // namespace softcd::benchmarks

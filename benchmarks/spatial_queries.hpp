#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

struct SpatialQueryOptions {
  std::string step_folder;  ///< empty: a generated cloth on a ball
  std::vector<Backend> backends = {Backend::cpu};
  std::size_t questions = 1000000;  ///< of each kind
  int repetitions = 5;
  bool measures_rivals = true;
  std::string machine;                   ///< empty: the processor
  std::string markdown_file, json_file;  ///< empty: none
};

/// Adds the subcommand `queries`, which fills `options` and then runs the benchmark.
void add_spatial_queries(CLI::App& app, SpatialQueryOptions& options);

}  // namespace softcd::benchmarks

#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

struct ChangesOptions {
  std::vector<Backend> backends = {Backend::cpu};
  double share = 0.01;  ///< of the triangles that one change replaces or adds
  int repetitions = 15;
  std::string machine;                   ///< empty: the processor
  std::string markdown_file, json_file;  ///< empty: none
};

/// Adds the subcommand `changes`, which fills `options` and then runs the benchmark.
void add_changes(CLI::App& app, ChangesOptions& options);

}  // namespace softcd::benchmarks

#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

namespace softcd::benchmarks {

struct CompareOptions {
  std::vector<std::string> arguments;          ///< two files of results, or the arguments of `detector`
  std::pair<std::string, std::string> builds;  ///< programs softcd-bench; empty: files are compared
  int rounds = 7;                              ///< of each build
  double tolerance = 5;                        ///< per cent
  bool found_loss = false;                     ///< the result: slower, more memory, or not measured any more
};

/// Adds the subcommand `compare`, which fills `options` and then compares.
void add_compare(CLI::App& app, CompareOptions& options);

}  // namespace softcd::benchmarks

#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace softcd::benchmarks {

struct UntanglingOptions {
  std::vector<std::string> bodies;  ///< empty: all kinds
  int size = 16;
  std::string machine;        ///< empty: the processor
  std::string markdown_file;  ///< empty: none
  std::string json_file;      ///< empty: none
};

/// Adds the subcommand `untangling`, which fills `options` and then runs the benchmark.
void add_untangling(CLI::App& app, UntanglingOptions& options);

}  // namespace softcd::benchmarks

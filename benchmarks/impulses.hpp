#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace softcd::benchmarks {

struct ImpulsesOptions {
  std::string machine;        ///< empty: the processor
  std::string markdown_file;  ///< empty: none
  std::string json_file;      ///< empty: none
};

/// Adds the subcommand `impulses`, which fills `options` and then compares impulses with changes of momentum.
void add_impulses(CLI::App& app, ImpulsesOptions& options);

}  // namespace softcd::benchmarks

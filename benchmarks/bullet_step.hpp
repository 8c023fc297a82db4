#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

struct BulletStepOptions {
  int nodes_per_side = 100;
  int warm_up_steps = 90;
  int measured_steps = 60;
  Backend backend = Backend::cpu;
  Detection detection = Detection::dcd;
  std::string json_file;  ///< empty: none
};

/// Adds the subcommand `bullet`, which fills `options` and then runs the benchmark.
void add_bullet_step(CLI::App& app, BulletStepOptions& options);

}  // namespace softcd::benchmarks

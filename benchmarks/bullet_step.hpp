#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

enum class BulletScene { two_cloths, balls };

struct BulletStepOptions {
  BulletScene scene = BulletScene::two_cloths;
  int nodes_per_side = 100;
  int warm_up_steps = 0;  ///< 0: the scene's default
  int measured_steps = 60;
  std::vector<Backend> backends = {Backend::cpu};
  Detection detection = Detection::dcd;
  std::string markdown_file;  ///< empty: none
  std::string json_file;      ///< empty: none
};

/// Adds the subcommand `bullet`, which fills `options` and then runs the benchmark.
void add_bullet_step(CLI::App& app, BulletStepOptions& options);

}  // namespace softcd::benchmarks

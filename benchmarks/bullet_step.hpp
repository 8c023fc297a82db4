#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "bullet_scenes.hpp"
#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

struct BulletStepOptions {
  BulletScene scene = BulletScene::two_cloths;
  World world = World::classic;
  int size = 100;         ///< see fill()
  int warm_up_steps = 0;  ///< 0: the scene's default
  int measured_steps = 60;
  int most_native_faces = 50000;  ///< of a body; with more, Bullet's own detection is left out
  std::vector<Backend> backends = {Backend::cpu};
  Detection detection = Detection::dcd;
  std::vector<bullet::Contacts> contacts = {bullet::Contacts::all};
  std::string machine;        ///< empty: the processor
  std::string markdown_file;  ///< empty: none
  std::string json_file;      ///< empty: none
};

/// Adds the subcommand `bullet`, which fills `options` and then runs the benchmark.
void add_bullet_step(CLI::App& app, BulletStepOptions& options);

}  // namespace softcd::benchmarks

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "bullet_step.hpp"

int main(int argc, char** argv) {
  try {
    CLI::App app("Benchmarks of softcd.", "softcd-bench");
    app.require_subcommand(1);
    softcd::benchmarks::BulletStepOptions bullet_step;
    softcd::benchmarks::add_bullet_step(app, bullet_step);
    CLI11_PARSE(app, argc, argv);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "softcd-bench: %s\n", error.what());
    return 1;
  }
}

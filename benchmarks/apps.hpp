#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "app_world.hpp"

namespace softcd::benchmarks {

/// The detector of an app: Bullet alone, or softcd with one of its presets.
enum class AppDetection : std::uint32_t { bullet, fast, balanced, safe };

struct AppsOptions {
  std::vector<std::string> apps;  ///< empty: all
  std::vector<AppWorldKind> worlds = {AppWorldKind::soft_rigid, AppWorldKind::soft_multi_body,
                                      AppWorldKind::deformable};
  std::vector<AppDetection> detections = {AppDetection::bullet, AppDetection::fast, AppDetection::balanced,
                                          AppDetection::safe};
  std::vector<int> iterations = {1, 4};  ///< Config::piterations of the bodies; unused in the deformable world
  int starts = 1;                        ///< number of runs; a row has their medians
  double seconds = 0;                    ///< simulated; 0: each app's own duration
  int splits = 1;                        ///< number of parts of each step
  Backend backend = Backend::cpu;
  std::string machine;        ///< empty: the processor
  std::string markdown_file;  ///< empty: none
  std::string json_file;      ///< empty: none
};

/// Adds the subcommand `apps`, which fills `options` and then runs the apps.
void add_apps(CLI::App& app, AppsOptions& options);

}  // namespace softcd::benchmarks

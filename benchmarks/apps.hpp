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
  std::vector<int> iterations = {1, 4};  ///< Config::piterations of the bodies; the deformable world has no such
  int starts = 1;                        ///< runs of which a row has the medians
  double seconds = 0;                    ///< simulated; 0: as long as each app takes
  Backend backend = Backend::cpu;
  std::string machine;        ///< empty: the processor
  std::string markdown_file;  ///< empty: none
  std::string json_file;      ///< empty: none
};

/// Adds the subcommand `apps`, which fills `options` and then runs the apps.
void add_apps(CLI::App& app, AppsOptions& options);

}  // namespace softcd::benchmarks

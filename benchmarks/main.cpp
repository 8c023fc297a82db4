#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#ifdef SOFTCD_BENCH_HAS_BULLET
#include "apps.hpp"
#include "bullet_step.hpp"
#include "crossings.hpp"
#include "impulses.hpp"
#include "simulated_scenes.hpp"
#include "untangling.hpp"
#endif
#include "changes.hpp"
#include "command_line/standard_output.hpp"
#include "compare.hpp"
#include "detector.hpp"
#include "mesh_tools/mesh_io.hpp"
#include "ranks.hpp"
#include "report.hpp"
#include "softcd/version.hpp"
#include "spatial_queries.hpp"
#include "trade.hpp"

namespace {

constexpr int kExitFailure = 1;     // a measurement failed or its results could not be written
constexpr int kExitWrongInput = 2;  // the command line or a mesh cannot be used
constexpr int kExitLoss = 3;        // compare: something is slower, needs more memory or is not measured any more

int fail(int exit_code, const std::exception& error) {
  std::fprintf(stderr, "softcd-bench: %s\n", error.what());
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace softcd::benchmarks;
  try {
    CLI::App app("Benchmarks of softcd.", "softcd-bench");
    app.set_version_flag("--version", std::string("softcd " SOFTCD_VERSION_STRING ", ") + kCompiler);
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 done; 1 a measurement failed or its results could not be written; 2 the command line or a\n"
        "mesh cannot be used; 3 `compare` found a loss.");
    DetectorOptions detector;
    add_detector(app, detector);
#ifdef SOFTCD_BENCH_HAS_BULLET
    BulletStepOptions bullet_step;
    add_bullet_step(app, bullet_step);
    SimulatedScenesOptions simulated_scenes;
    add_simulated_scenes(app, simulated_scenes);
    CrossingsOptions crossings;
    add_crossings(app, crossings);
    AppsOptions apps;
    add_apps(app, apps);
    ImpulsesOptions impulses;
    add_impulses(app, impulses);
    UntanglingOptions untangling;
    add_untangling(app, untangling);
#endif
    SpatialQueryOptions spatial_queries;
    add_spatial_queries(app, spatial_queries);
    ChangesOptions changes;
    add_changes(app, changes);
    RankOptions ranks;
    add_ranks(app, ranks);
    TradeOptions trade;
    add_trade(app, trade);
    CompareOptions compare;
    add_compare(app, compare);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (app.exit(error) != 0) return kExitWrongInput;
    }
    softcd::demo::finish_standard_output();
    return compare.found_loss ? kExitLoss : 0;
  } catch (const softcd::mesh_tools::MeshError& error) {
    return fail(kExitWrongInput, error);
  } catch (const softcd::InvalidInput& error) {
    return fail(kExitWrongInput, error);
  } catch (const std::exception& error) {
    return fail(kExitFailure, error);
  }
}

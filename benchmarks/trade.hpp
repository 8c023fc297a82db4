#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#ifdef SOFTCD_BENCH_HAS_BULLET
#include "scenes/soft_world.hpp"
#endif
#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

enum class TradePart : std::uint32_t { queries, steps, simulation };

struct TradeOptions {
#ifdef SOFTCD_BENCH_HAS_BULLET
  std::vector<TradePart> parts = {TradePart::queries, TradePart::steps, TradePart::simulation};
  std::vector<demo::World> worlds = {demo::World::classic};
#else
  std::vector<TradePart> parts = {TradePart::queries, TradePart::steps};
#endif
  std::string queries_folder;  ///< empty: generated queries alone
  std::string steps_folder;    ///< empty: generated scenes
  std::vector<Backend> backends = {Backend::cpu};
  int generated_queries = 20000;  ///< of each set
  double scale = 1;               ///< of the generated scenes' triangle counts
  int repetitions = 9;
  double simulated_seconds = 1;
  int simulation_runs = 3;
  int nodes_per_side = 24;                           ///< of the simulated cloths
  std::string machine;                               ///< empty: the processor
  std::string markdown_file, json_file, csv_folder;  ///< empty: none
};

/// Adds the subcommand `trade`, which fills `options` and then runs the benchmark.
void add_trade(CLI::App& app, TradeOptions& options);

}  // namespace softcd::benchmarks

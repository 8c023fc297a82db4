#include "trade.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "command_line/choices.hpp"
#include "report.hpp"
#include "trade_queries.hpp"
#ifdef SOFTCD_BENCH_HAS_BULLET
#include "command_line/world_choices.hpp"
#include "trade_simulation.hpp"
#endif
#include "trade_steps.hpp"

// Measures the cost of accuracy: every mode detects the same contacts, and exact arithmetic judges each mode.

namespace softcd::benchmarks {
namespace {

namespace fs = std::filesystem;
using demo::name_of;
using nlohmann::ordered_json;

constexpr std::array<demo::Choice<TradePart>, 3> kParts = {
    {{"queries", TradePart::queries}, {"steps", TradePart::steps}, {"simulation", TradePart::simulation}}};

constexpr std::array<demo::Choice<ContactKind>, 2> kKindNames = {
    {{"vt", ContactKind::vertex_triangle}, {"ee", ContactKind::edge_edge}}};

std::string scientific(double value) {
  return std::isfinite(value) ? fmt::format("{:.1e}", value) : "";
}

/// Returns the folders in the order of their names; none where `folder` is empty.
std::vector<fs::path> folders_in(const std::string& folder) {
  std::vector<fs::path> folders;
  if (folder.empty()) return folders;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

ordered_json to_json(const QueryResult& r) {
  return {{"set", r.set},
          {"kind", name_of(kKindNames, r.kind)},
          {"mode", r.mode},
          {"margin", r.margin},
          {"queries", r.queries},
          {"touching", r.touching},
          {"missed", r.missed},
          {"false_alarms", r.false_alarms},
          {"early", r.early.count},
          {"early_median", r.early.median},
          {"early_999", r.early.permille_999},
          {"early_max", r.early.most},
          {"late", r.late.count},
          {"late_median", r.late.median},
          {"late_999", r.late.permille_999},
          {"late_max", r.late.most},
          {"ns_per_query", r.nanoseconds}};
}

ordered_json to_json(const StepResult& r) {
  return {{"scene", r.scene},
          {"features", r.has_edges ? "vt,ee" : "vt"},
          {"mode", r.mode},
          {"backend", demo::name_of(r.backend)},
          {"triangles", r.triangles},
          {"margin", r.margin},
          {"candidates", r.is_listed ? "listed" : "reported"},
          {"touching", r.touching},
          {"contacts", r.contacts},
          {"missed", r.missed},
          {"extra", r.extra},
          {"unsettled", r.unsettled},
          {"ms", r.ms},
          {"transfer_ms", r.transfer_ms}};
}

#ifdef SOFTCD_BENCH_HAS_BULLET

ordered_json to_json(const SimulationResult& r) {
  return {{"scene", r.scene},
          {"world", name_of(demo::kWorlds, r.world)},
          {"knob", r.knob},
          {"value", r.value},
          {"detection", r.detection},
          {"features", r.features},
          {"accuracy", r.accuracy},
          {"backend", demo::name_of(r.backend)},
          {"steps_per_second", r.steps_per_second},
          {"margin_in_cells", r.margin_in_cells},
          {"cell_size_factor", r.cell_size_factor},
          {"iterations", r.iterations},
          {"seconds", r.seconds},
          {"vertices", r.vertices},
          {"penetrating", r.penetrating},
          {"most_penetrating", r.most_penetrating},
          {"crossings", r.crossings},
          {"tunnelled", r.tunnelled},
          {"energy_start", r.energy_start},
          {"energy_end", r.energy_end},
          {"energy_most", r.energy_most},
          {"contacts", r.contacts},
          {"ms_per_second", r.ms_per_second},
          {"processor_ms_per_second", r.processor_ms_per_second}};
}
#endif

class Trade {
 public:
  explicit Trade(const TradeOptions& options) : options_(options), json_(describe_run("trade", options.machine)) {
    json_["repetitions"] = options.repetitions;
  }

  void run() {
    for (const TradePart part : options_.parts) {
      switch (part) {
        case TradePart::queries:
          run_queries();
          break;
        case TradePart::steps:
          run_steps();
          break;
        case TradePart::simulation:
          run_simulation();
          break;
      }
    }
    if (!options_.markdown_file.empty()) write_file(options_.markdown_file, report_);
    if (!options_.json_file.empty()) write_json(options_.json_file, json_);
    if (!options_.csv_folder.empty()) write_csvs();
  }

 private:
  void run_queries() {
    std::vector<QuerySet> sets = generate_queries(static_cast<std::size_t>(options_.generated_queries));
    const auto add = [&](std::vector<QuerySet> more) {
      sets.insert(sets.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
    };
    for (const fs::path& folder : folders_in(options_.queries_folder)) add(read_query_sets(folder));
    for (const auto& [name, truth] : recorded_steps()) add(queries_of_step(name, truth));
    Table table({"set", "kind", "mode", "queries", "touch", "missed", "false", "early", "median", "99.9 %", "most",
                 "late", "median", "99.9 %", "most", "ns"},
                3);
    for (const QuerySet& set : sets) {
      for (const QueryResult& r : measure_queries(set, options_.repetitions)) {
        json_["queries"].push_back(to_json(r));
        table.add({r.set, name_of(kKindNames, r.kind), r.mode, fmt::to_string(r.queries), fmt::to_string(r.touching),
                   fmt::to_string(r.missed), fmt::to_string(r.false_alarms), fmt::to_string(r.early.count),
                   scientific(r.early.median), scientific(r.early.permille_999), scientific(r.early.most),
                   fmt::to_string(r.late.count), scientific(r.late.median), scientific(r.late.permille_999),
                   scientific(r.late.most), fmt::format("{:.0f}", r.nanoseconds)});
      }
    }
    add_section("Single queries",
                "Against exact arithmetic. `early` and `late`: found, at a time before or after that of the first "
                "contact, in steps. `fast`, `precise` and `conservative`: what CollisionPipeline answers for positions "
                "in double; ns are those of the test alone. `dcd-N`: distances at the ends of N substeps, within a "
                "tenth of the set's median edge.",
                table);
  }

  void run_steps() {
    std::vector<StepScene> scenes;
    for (const MakeScene make : {make_funnel, make_cloth_on_ball, make_n_body}) {
      scenes.push_back({make(options_.scale), {}});
    }
    for (const auto& [name, truth] : recorded_steps()) scenes.push_back(to_step_scene(name, truth));
    Table table({"scene", "features", "mode", "backend", "triangles", "touch", "contacts", "missed", "extra",
                 "unsettled", "ms", "transfer"},
                4);
    for (const StepScene& scene : scenes) {
      for (const StepResult& r : measure_steps(scene, options_.backends, options_.repetitions)) {
        json_["steps"].push_back(to_json(r));
        table.add({r.scene, r.has_edges ? "vt,ee" : "vt", r.mode, demo::name_of(r.backend), fmt::to_string(r.triangles),
                   fmt::to_string(r.touching), fmt::to_string(r.contacts), fmt::to_string(r.missed),
                   fmt::to_string(r.extra), fmt::to_string(r.unsettled), fmt::format("{:.2f}", r.ms),
                   fmt::format("{:.2f}", r.transfer_ms)});
      }
    }
    add_section("Whole steps",
                "`touch`: pairs of features that do so in exact arithmetic, of those that a mode reports or "
                "the recorded step lists. `dcd-N`: detections at the ends of N substeps, within a tenth of an edge, "
                "milliseconds of all together, without `transfer`.",
                table);
  }

#ifdef SOFTCD_BENCH_HAS_BULLET
  void run_simulation() {
    Table table({"scene", "world", "knob", "value", "detection", "features", "vertices", "penetrating", "most",
                 "crossings", "tunnelled", "J, start", "J, end", "J, most", "contacts", "ms per s", "processor ms"},
                6);
    for (const auto& [world, backend] : worlds_and_backends()) {
      run_simulations(
          {world, backend, options_.nodes_per_side, options_.simulated_seconds, options_.simulation_runs},
          [&](const SimulationResult& r) {
            json_["simulation"].push_back(to_json(r));
            table.add({r.scene, name_of(demo::kWorlds, r.world), r.knob, r.value, r.detection, r.features,
                       fmt::to_string(r.vertices), fmt::to_string(r.penetrating), fmt::to_string(r.most_penetrating),
                       fmt::to_string(r.crossings), fmt::to_string(r.tunnelled), fmt::format("{:.1f}", r.energy_start),
                       fmt::format("{:.1f}", r.energy_end), fmt::format("{:.1f}", r.energy_most),
                       fmt::format("{:.0f}", r.contacts), fmt::format("{:.0f}", r.ms_per_second),
                       fmt::format("{:.0f}", r.processor_ms_per_second)});
          });
    }
    add_section("Simulations",
                "Knobs are turned one at a time from `ccd`, `precise`, vertex-triangle, "
                "steps of 1/120 s, margins of a quarter of a cell, 4 iterations. `penetrating`: vertices with an edge "
                "through a triangle, at the end, and the most; `crossings`: of vertices through triangles, in exact "
                "arithmetic; `tunnelled`: vertices with an odd number of them.",
                table);
  }
  std::vector<std::pair<demo::World, Backend>> worlds_and_backends() const {
    std::vector<std::pair<demo::World, Backend>> all;
    for (const demo::World world : options_.worlds) {
      for (const Backend backend : options_.backends) all.emplace_back(world, backend);
    }
    return all;
  }
#else
  void run_simulation() {
    throw std::runtime_error("--part simulation: this program was built without Bullet (SOFTCD_BULLET=ON)");
  }
#endif

  std::vector<std::pair<std::string, test::GroundTruth>> recorded_steps() const {
    std::vector<std::pair<std::string, test::GroundTruth>> steps;
    for (const fs::path& folder : folders_in(options_.steps_folder)) {
      const std::string name = folder.filename().string();
      steps.emplace_back(name, test::read_ground_truth(options_.steps_folder, name));
    }
    return steps;
  }

  void add_section(const std::string& title, const std::string& note, const Table& table) {
    const std::string section = fmt::format("### {}\n\n{}\n\n{}\n", title, note, table.text());
    fmt::print("{}", section);
    std::fflush(stdout);
    report_ += section;
  }

  void write_csvs() const {
    for (const auto& part : kParts) {
      if (json_.contains(part.name)) {
        write_file((fs::path(options_.csv_folder) / part.name).string() + ".csv", csv_of(json_[part.name]));
      }
    }
  }

  const TradeOptions& options_;
  std::string report_;
  ordered_json json_;
};

}  // namespace

void add_trade(CLI::App& app, TradeOptions& options) {
  CLI::App* command = app.add_subcommand(
      "trade",
      "Measures the cost of accuracy: continuous detection in every mode and discrete detection in substeps, on "
      "single\n"
      "queries and whole steps, judged by exact arithmetic; and simulations in Bullet with several time steps\n"
      "and settings");
  demo::add_choices(*command, "--part", kParts, options.parts, "The parts to measure");
  command
      ->add_option("--queries", options.queries_folder,
                   "Also these queries: folders of vertex-face/*.csv and edge-edge/*.csv, 8 rows a query, each\n"
                   "coordinate as numerator and denominator")
      ->option_text("DIR")
      ->check(CLI::ExistingDirectory);
  command
      ->add_option("--steps", options.steps_folder,
                   "Also these recorded steps: folders of frames/ (two meshes), boxes/ (pairs that may touch) and\n"
                   "mma_bool/ (verdicts), as the sample data of Scalable CCD")
      ->option_text("DIR")
      ->check(CLI::ExistingDirectory);
  command->add_option("--generated", options.generated_queries, "Queries of each generated set")
      ->option_text("N [20000]")
      ->check(CLI::Range(1, 10000000));
  command->add_option("--scale", options.scale, "Multiplies the generated scenes' triangle counts, roughly")
      ->option_text("S [1]")
      ->check(CLI::Range(0.01, 1000.0));
  demo::add_choices(*command, "--backend", options.backends, "The backends for whole steps");
  command->add_option("--repeat", options.repetitions, "Measured rounds; the median is reported")
      ->option_text("N [9]")
      ->check(CLI::Range(1, 1000000));
  command->add_option("--seconds", options.simulated_seconds, "Simulated seconds of each run")
      ->option_text("S [1]")
      ->check(CLI::Range(0.01, 1000.0));
#ifdef SOFTCD_BENCH_HAS_BULLET
  demo::add_choices(*command, "--world", demo::kWorlds, options.worlds, "Bullet's worlds for the simulations");
#endif
  command->add_option("--runs", options.simulation_runs, "Runs of each simulation; the median time is reported")
      ->option_text("N [3]")
      ->check(CLI::Range(1, 1000));
  command->add_option("--nodes", options.nodes_per_side, "Nodes a side of the simulated cloths")
      ->option_text("N [24]")
      ->check(CLI::Range(8, 1000));
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the tables as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure as JSON, for benchmarks/report.py")
      ->option_text("FILE");
  command->add_option("--csv", options.csv_folder, "Write queries.csv, steps.csv and simulation.csv there")
      ->option_text("DIR")
      ->check(CLI::ExistingDirectory);
  command->callback([&options] { Trade(options).run(); });
}

}  // namespace softcd::benchmarks

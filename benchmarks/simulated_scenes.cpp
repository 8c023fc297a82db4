#include "simulated_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "command_line/stage_times.hpp"
#include "command_line/statistics_json.hpp"
#include "command_line/world_choices.hpp"
#include "detector_measurement.hpp"
#include "report.hpp"
#include "soft_body_steps.hpp"

// Measures the detector on steps of the demo scenes, which are simulated first: the paper's Table 1 and Figs. 13 to 15
// for softcd's scenes.

namespace softcd::benchmarks {
namespace {

using demo::name_of;

constexpr std::array<demo::Choice<bool>, 2> kSizes = {{{"paper", true}, {"default", false}}};

/// Wong, Leach and Zambetta 2012, Table 1: thousands of triangles, milliseconds on a GTX 470.
struct PapersRow {
  const char* scene;
  int thousand_triangles;
  double dcd_ms, ccd_ms;
};
constexpr PapersRow kPapersTable[] = {{"funnel", 18, 5.1, 5.6},     {"cloth-on-ball", 92, 12.0, 14.8},
                                      {"flamenco", 49, 14.2, 16.1}, {"n-body", 146, 26.7, 31.2},
                                      {"reef-knot", 20, 5.5, 6.0},  {"bowline", 12, 4.3, 4.0}};

const PapersRow* papers_row(const std::string& scene) {
  const auto* row = std::find_if(std::begin(kPapersTable), std::end(kPapersTable),
                                 [&](const PapersRow& candidate) { return candidate.scene == scene; });
  return row == std::end(kPapersTable) ? nullptr : row;
}

std::vector<Vec3f> positions_of(const btSoftBody& body) {
  std::vector<Vec3f> positions;
  positions.reserve(static_cast<std::size_t>(body.m_nodes.size()));
  for (int n = 0; n < body.m_nodes.size(); ++n) {
    const btVector3& x = body.m_nodes[n].m_x;
    positions.push_back({static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())});
  }
  return positions;
}

SceneBody to_scene_body(btSoftBody& body) {
  SceneBody result;
  bool is_fixed = true;
  for (int n = 0; n < body.m_nodes.size(); ++n) is_fixed &= body.m_nodes[n].m_im == 0;
  result.triangles = test::triangles_of(body);
  result.settings.kinematic = is_fixed;
  result.settings.self_collision = !is_fixed && body.useSelfCollision();
  return result;
}

/// Returns the edge length of the body with the finest mesh.
double edge_length_of(const DetectorScene& scene) {
  double least = INFINITY;
  for (const SceneBody& body : scene.bodies) {
    double sum = 0;
    for (const Triangle& t : body.triangles) {
      for (int side = 0; side < 3; ++side) {
        sum += std::sqrt(static_cast<double>(squared_norm(body.x_t1[t.v[side]] - body.x_t1[t.v[(side + 1) % 3]])));
      }
    }
    if (!body.triangles.empty()) least = std::min(least, sum / (3.0 * static_cast<double>(body.triangles.size())));
  }
  return least;
}

/// Counts the steps by what the detection, the last of a pass, used. Leaves out steps in which nothing may touch.
struct PassCounts {
  long served = 0;         ///< by kept pairs alone
  long partly_served = 0;  ///< by kept pairs, and some triangles were looked up
  long fresh = 0;          ///< not by kept pairs

  void count(const Statistics& statistics) {
    if (statistics.active_triangles == 0) return;
    if (!statistics.reused_pairs) {
      ++fresh;
    } else if (statistics.looked_up_triangles == 0) {
      ++served;
    } else {
      ++partly_served;
    }
  }
};

struct Recording {
  std::vector<DetectorScene> steps;
  std::size_t triangles = 0;
  double step_ms = 0;  ///< median, of the simulation with softcd
  PassCounts contacts, crossings;
  long steps_with_responses = 0;  ///< of crossing prevention: it detects several times in them
};

/// Simulates a scene with softcd and keeps steps at equal intervals, including the last one.
Recording record(const std::string& name, const SimulatedScenesOptions& options) {
  const demo::SceneInfo& info = *demo::find_scene(name);
  demo::SceneOptions scene_options;
  scene_options.world = options.world;
  scene_options.settings.detection = Detection::ccd;
  scene_options.settings.edge_contacts = bullet::EdgeContacts::respond;
  scene_options.size = options.papers_sizes && info.paper_size > 0 ? info.paper_size : info.default_size;
  const std::unique_ptr<demo::Scene> scene = demo::make_scene(name, scene_options);

  Recording recording;
  std::vector<double> step_ms;
  const std::vector<btSoftBody*>& bodies = scene->simulation().bodies();
  for (long step = 1; step <= options.steps; ++step) {
    const bool is_kept = step * options.samples / options.steps > (step - 1) * options.samples / options.steps;
    DetectorScene kept;
    kept.name = name;
    if (is_kept) {
      for (btSoftBody* body : bodies) {
        kept.bodies.push_back(to_scene_body(*body));
        kept.bodies.back().x_t0 = positions_of(*body);
      }
    }
    const auto start = std::chrono::steady_clock::now();
    scene->step();
    step_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    const bullet::WorldDetection& detection = *scene->simulation().detection();
    recording.contacts.count(detection.contact_report().statistics());
    recording.crossings.count(detection.crossing_report().statistics());
    recording.steps_with_responses += detection.crossing_answers().rounds > 0 ? 1 : 0;
    if (!is_kept) continue;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      kept.bodies[b].x_t1 = positions_of(*bodies[b]);
      // Nodes that the step has added come last.
      kept.bodies[b].x_t1.resize(kept.bodies[b].x_t0.size());
    }
    kept.edge_length = edge_length_of(kept);
    recording.triangles = kept.triangle_count();
    recording.steps.push_back(std::move(kept));
  }
  recording.step_ms = demo::median(step_ms);
  return recording;
}

/// Means over a recording's steps.
struct Means {
  Backend backend = Backend::automatic;  ///< the backend that was used
  double ms = 0;                         ///< without transfers
  StageTimes stages;
  double children = 0, tests = 0, contacts = 0;
  double peak_bytes = 0;  ///< largest
};

std::string decimals(double value, int digits) {
  return fmt::format("{:.{}f}", value, digits);
}

class Benchmark {
 public:
  explicit Benchmark(const SimulatedScenesOptions& options) : options_(options) {
    json_["simulated_steps"] = options.steps;
    json_["samples"] = options.samples;
    json_["margin_in_edges"] = kMarginInEdges;
    for (const PapersRow& row : kPapersTable) {
      json_["paper"].push_back({{"scene", row.scene},
                                {"triangles", 1000 * row.thousand_triangles},
                                {"dcd_ms", row.dcd_ms},
                                {"ccd_ms", row.ccd_ms}});
    }
  }

  void run() {
    for (const demo::SceneInfo& info : demo::scenes()) {
      const bool is_wanted =
          (options_.scenes.empty() && !info.starts_tangled) ||
          std::find(options_.scenes.begin(), options_.scenes.end(), info.name) != options_.scenes.end();
      if (is_wanted && (options_.world == demo::World::classic || info.in_deformable_world)) run_scene(info.name);
    }
    const std::string report = fmt::format(
        "### Simulated scenes\n\nMeans over {} steps at equal distances in {} steps of 1/120 second. Milliseconds "
        "without transfers. The paper's are of a GTX 470.\n\n{}\n### Shares of a continuous detection\n\nPer "
        "cent.\n\n{}\n### Cell size\n\nPairs tested in the continuous detection of the last of these steps, in "
        "thousands, over cell_size_factor: the cells' width in mean radii.\n\n{}\n### Kept pairs\n\nSimulated steps by "
        "what their detections used: kept pairs alone, kept pairs beside some triangles that were looked up (partly), "
        "or no kept pairs (fresh). Of crossing prevention the last detection counts. Steps with responses have "
        "several.\n\n{}\n",
        options_.samples, options_.steps, table_.text(), shares_.text(), cell_sizes_.text(), kept_.text());
    fmt::print("\n{}", report);
    if (!options_.markdown_file.empty()) write_file(options_.markdown_file, report);
    if (!options_.json_file.empty()) write_json(options_.json_file, json_);
    if (!options_.csv_file.empty()) write_file(options_.csv_file, csv_of(json_["simulated_scenes"]));
  }

 private:
  void run_scene(const std::string& name) {
    fmt::print(stderr, "{}: simulating {} steps\n", name, options_.steps);
    const Recording recording = record(name, options_);
    const std::optional<double> uniform_tests = tests_of_uniform_grid(recording);
    add_cell_sizes(name, recording.steps.back());
    add_kept(name, recording);
    for (const Backend backend : options_.backends) {
      fmt::print(stderr, "{}: measuring on {}\n", name, demo::name_of(backend));
      const Means dcd = means(recording, Detection::dcd, Accuracy::fast, backend);
      const Means ccd = means(recording, Detection::ccd, Accuracy::precise, backend);
      add_rows(name, recording, dcd, ccd, uniform_tests);
    }
  }

  Means means(const Recording& recording, Detection detection, Accuracy accuracy, Backend backend) {
    MeasuredOptions options;
    options.backend = backend;
    options.detection = detection;
    options.accuracy = accuracy;
    Means sum;
    const double share = 1.0 / static_cast<double>(recording.steps.size());
    for (std::size_t step = 0; step < recording.steps.size(); ++step) {
      const Measurement m = measure(recording.steps[step], options, options_.repetitions);
      const Statistics& s = m.statistics;
      sum.backend = m.options.backend;
      sum.ms += share * (s.ms.total - s.ms.transfer);
      for (const demo::StageTime& stage : demo::kStageTimes) sum.stages.*stage.ms += share * s.ms.*stage.ms;
      sum.children += share * static_cast<double>(s.children);
      sum.tests += share * static_cast<double>(s.tests);
      sum.contacts += share * static_cast<double>(s.vt_contacts + s.ee_contacts);
      sum.peak_bytes = std::max(sum.peak_bytes, static_cast<double>(s.peak_bytes));
      record_step(m, step);
    }
    return sum;
  }

  /// Returns the number of tests of the traditional grid, whose cells fit the largest triangle, for the continuous
  /// detection of the last step. Returns nothing where counting would take too long.
  std::optional<double> tests_of_uniform_grid(const Recording& recording) const {
    if (estimate_uniform_tests(recording.steps.back()) > options_.most_tests) return std::nullopt;
    MeasuredOptions options;
    options.backend = options_.backends.front();
    options.detection = Detection::ccd;
    options.broad_phase = BroadPhase::uniform;
    const double tests = static_cast<double>(measure(recording.steps.back(), options, 1).statistics.tests);
    options.broad_phase = BroadPhase::exact;
    return tests / static_cast<double>(measure(recording.steps.back(), options, 1).statistics.tests);
  }

  void add_cell_sizes(const std::string& name, const DetectorScene& step) {
    MeasuredOptions options;
    options.backend = options_.backends.front();
    options.detection = Detection::ccd;
    std::vector<std::string> row = {name};
    for (const float factor : kCellSizeFactors) {
      options.cell_size_factor = factor;
      row.push_back(fmt::format("{:.0f}", static_cast<double>(measure(step, options, 1).statistics.tests) / 1000));
    }
    cell_sizes_.add(row);
  }

  void add_kept(const std::string& name, const Recording& recording) {
    std::vector<std::string> row = {name};
    for (const PassCounts& pass : {recording.contacts, recording.crossings}) {
      for (const long steps : {pass.served, pass.partly_served, pass.fresh}) row.push_back(fmt::to_string(steps));
    }
    row.push_back(fmt::to_string(recording.steps_with_responses));
    kept_.add(row);
  }

  static std::vector<std::string> cell_sizes_header() {
    std::vector<std::string> header = {"scene"};
    for (const float factor : kCellSizeFactors) header.push_back(decimals(static_cast<double>(factor), 1));
    return header;
  }

  void add_rows(const std::string& name, const Recording& recording, const Means& dcd, const Means& ccd,
                const std::optional<double>& uniform_tests) {
    const PapersRow* paper = papers_row(name);
    const char* backend_name = demo::name_of(ccd.backend);
    table_.add({name, backend_name, fmt::to_string(recording.triangles), decimals(dcd.ms, 3), decimals(ccd.ms, 3),
                decimals(ccd.children / static_cast<double>(recording.triangles), 3), fmt::format("{:.0f}", ccd.tests),
                uniform_tests ? decimals(*uniform_tests, 1) : "-", fmt::format("{:.0f}", dcd.contacts),
                fmt::format("{:.0f}", ccd.contacts), decimals(ccd.peak_bytes / 1e6, 0), decimals(recording.step_ms, 1),
                paper != nullptr ? fmt::format("{}K", paper->thousand_triangles) : "-",
                paper != nullptr ? decimals(paper->dcd_ms, 1) : "-",
                paper != nullptr ? decimals(paper->ccd_ms, 1) : "-"});
    std::vector<std::string> row = {name, backend_name};
    double sum = 0;
    for (const demo::StageTime& stage : kShares) sum += ccd.stages.*stage.ms;
    for (const demo::StageTime& stage : kShares) row.push_back(decimals(100 * ccd.stages.*stage.ms / sum, 0));
    shares_.add(row);
  }

  void record_step(const Measurement& m, std::size_t step) {
    nlohmann::ordered_json row = {{"scene", m.scene},
                                  {"sample", step},
                                  {"backend", demo::name_of(m.options.backend)},
                                  {"detection", demo::name_of(m.options.detection)}};
    demo::add_statistics(row, m.statistics);
    json_["simulated_scenes"].push_back(row);
  }

  static constexpr std::array<demo::StageTime, 7> kShares = {{{"volumes", &StageTimes::volumes},
                                                              {"subdivision", &StageTimes::subdivision},
                                                              {"assignment", &StageTimes::assignment},
                                                              {"sort", &StageTimes::sort},
                                                              {"tests", &StageTimes::tests},
                                                              {"features", &StageTimes::features},
                                                              {"narrow", &StageTimes::narrow}}};

  static constexpr std::array<float, 7> kCellSizeFactors = {0.8F, 1.2F, 1.5F, 1.8F, 2.1F, 2.4F, 3.0F};

  const SimulatedScenesOptions& options_;
  Table table_{{"scene", "backend", "triangles", "dcd ms", "ccd ms", "children/triangles", "tests", "uniform/exact",
                "dcd contacts", "ccd contacts", "MB", "step ms", "paper", "its dcd ms", "its ccd ms"},
               2};
  Table shares_{{"scene", "backend", "volumes", "subdivision", "assignment", "sort", "tests", "features", "narrow"}, 2};
  Table cell_sizes_{cell_sizes_header(), 1};
  Table kept_{{"scene", "contacts kept", "partly", "fresh", "crossings kept", "partly", "fresh", "with responses"}, 1};
  nlohmann::ordered_json json_ = describe_run("scenes", options_.machine);
};

}  // namespace

void add_simulated_scenes(CLI::App& app, SimulatedScenesOptions& options) {
  CLI::App* command = app.add_subcommand(
      "scenes",
      "Measures the detector alone on steps of the demo scenes, which Bullet simulates first, with softcd: discrete\n"
      "detection in float32 (contacts within a tenth of an edge) and continuous detection in float64 (collisions),\n"
      "vertex-triangle and edge-edge, beside the paper's figures. Median times in milliseconds");
  command->add_option("--scene", options.scenes, "See softcd-demo --list; several by commas")
      ->option_text("SCENE [all]")
      ->delimiter(',')
      ->check([](const std::string& name) {
        return demo::find_scene(name) != nullptr ? std::string() : "there is no scene '" + name + "'";
      });
  demo::add_choice(*command, "--world", demo::kWorlds, options.world, "Bullet's world that simulates");
  demo::add_choice(*command, "--size", kSizes, options.papers_sizes,
                   "paper: the paper's scenes have its number of triangles, the others their defaults");
  command->add_option("--steps", options.steps, "Simulated steps of 1/120 second")
      ->option_text("N [600]")
      ->check(CLI::Range(1L, 1000000L));
  command->add_option("--samples", options.samples, "Number of measured steps, at equal intervals; at most --steps")
      ->option_text("N [8]")
      ->check(CLI::Range(1, 10000));
  demo::add_choices(*command, "--backend", options.backends, "The backends to measure, one after the other");
  command->add_option("--repeat", options.repetitions, "Measured detections of a step, after 3 to warm up")
      ->option_text("N [20]")
      ->check(CLI::Range(1, 1000000));
  command
      ->add_option(
          "--most-tests", options.most_tests,
          "Skip counting the tests of a grid for the largest triangle where they would be more, by an estimate")
      ->option_text("N [2e10]")
      ->check(CLI::PositiveNumber);
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the tables as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure of every step; milliseconds and bytes")
      ->option_text("FILE");
  command->add_option("--csv", options.csv_file, "Write the same as CSV, one row a measurement")->option_text("FILE");
  command->callback([&options] {
    options.samples = static_cast<int>(std::min<long>(options.samples, options.steps));
    Benchmark(options).run();
  });
}

}  // namespace softcd::benchmarks

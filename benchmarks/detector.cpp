#include "detector.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "command_line/choices.hpp"
#include "command_line/stage_times.hpp"
#include "command_line/statistics_json.hpp"
#include "detector_measurement.hpp"
#include "report.hpp"
#include "softcd/core/parallel.hpp"

// Measures the detector alone: from positions in the caller's memory to contacts.

namespace softcd::benchmarks {
namespace {

using demo::name_of;

constexpr std::array<demo::Choice<Sweep>, 7> kSweeps = {{{"stages", Sweep::stages},
                                                         {"subdivision", Sweep::subdivision},
                                                         {"cell_size_factor", Sweep::cell_size_factor},
                                                         {"scaling", Sweep::scaling},
                                                         {"threads", Sweep::threads},
                                                         {"ends", Sweep::ends},
                                                         {"reuse", Sweep::reuse}}};

// Cell size factors, in tenths.
constexpr int kLeastTenths = 8;
constexpr int kMostTenthsExact = 24;
constexpr int kMostTenthsPaper = 20;
constexpr int kTenthsStep = 2;

constexpr double kLeastScalingTriangles = 8000;
constexpr double kScalingFactor = 4;

std::string decimals(double value, int digits) {
  return fmt::format("{:.{}f}", value, digits);
}

std::string megabytes(std::uint64_t bytes) {
  return decimals(static_cast<double>(bytes) / 1e6, 1);
}

/// Returns the time without copies of positions and contacts between host and device.
double work_ms(const Measurement& m) {
  return m.statistics.ms.total - m.statistics.ms.transfer;
}

std::uint64_t contact_count(const Measurement& m) {
  return m.statistics.vt_contacts + m.statistics.ee_contacts;
}

double children_ratio(const Measurement& m) {
  return static_cast<double>(m.statistics.children) / static_cast<double>(m.statistics.triangles);
}

std::string detection_of(const Measurement& m) {
  return fmt::format("{} {}", demo::name_of(m.options.detection), demo::name_of(m.options.accuracy));
}

std::string broad_phase_of(const Measurement& m) {
  return m.options.is_paper ? "paper" : demo::name_of(m.options.broad_phase);
}

bool is_exact(const Measurement& m) {
  return !m.options.is_paper && m.options.broad_phase == BroadPhase::exact;
}

std::string broad_phase_and_subdivision_of(const Measurement& m) {
  return broad_phase_of(m) + (is_exact(m) && !m.options.subdivision ? ", subdivision off" : "");
}

nlohmann::ordered_json to_json(Sweep sweep, const Measurement& m) {
  const Statistics& s = m.statistics;
  nlohmann::ordered_json json = {{"sweep", name_of(kSweeps, sweep)},
                                 {"scene", m.scene},
                                 {"backend", demo::name_of(m.options.backend)},
                                 {"detection", demo::name_of(m.options.detection)},
                                 {"accuracy", demo::name_of(m.options.accuracy)},
                                 {"broad_phase", broad_phase_of(m)},
                                 {"subdivision", m.options.subdivision},
                                 {"cell_size_factor", m.options.cell_size_factor},
                                 {"ends", m.options.on_device ? "device" : "host"},
                                 {"reuse_pairs", m.options.reuse_pairs},
                                 {"rocks", m.options.rocks},
                                 {"threads", m.threads},
                                 {"repetitions", m.repetitions},
                                 {"triangles", s.triangles}};
  if (!m.left_out.empty()) {
    json["left_out"] = m.left_out;
    return json;
  }
  demo::add_statistics(json, s);
  json["contacts_checksum"] = fmt::format("{:016x}", m.checksum);
  json["wall_ms"] = m.wall_ms;
  json["total_ms_quartiles"] = {{"first", m.first_quartile_ms}, {"third", m.third_quartile_ms}};
  return json;
}

class Benchmark {
 public:
  explicit Benchmark(const DetectorOptions& options) : options_(options) {
    json_["scale"] = options.scale;
    json_["margin_in_edges"] = kMarginInEdges;
  }

  void run() {
    if (options_.first_frame.empty()) {
      for (const MakeScene make : options_.scenes) scenes_.push_back(make(options_.scale));
    } else {
      scenes_.push_back(read_scene(options_.first_frame, options_.second_frame));
    }
    for (const std::string& folder : options_.step_folders) scenes_.push_back(read_recorded_step(folder));
    for (const Backend backend : options_.backends) {
      for (const Sweep sweep : options_.sweeps) {
        sweep_ = sweep;
        run_sweep(backend);
      }
    }
    if (!options_.markdown_file.empty()) write_file(options_.markdown_file, report_);
    if (!options_.json_file.empty()) write_json(options_.json_file, json_);
    if (!options_.csv_file.empty()) write_file(options_.csv_file, csv_of(json_["rows"]));
    if (!error_.empty()) throw std::runtime_error(error_);
  }

 private:
  using Measurements = std::vector<Measurement>;

  void run_sweep(Backend backend) {
    switch (sweep_) {
      case Sweep::stages:
        return report_stages(
            for_each_scene_and_mode(backend, [this](const DetectorScene& scene, const MeasuredOptions& options) {
              return Measurements{measure_one(scene, options)};
            }));
      case Sweep::subdivision:
        return report_subdivision(
            for_each_scene_and_mode(backend, [this](const DetectorScene& scene, const MeasuredOptions& options) {
              return with_every_broad_phase(scene, options);
            }));
      case Sweep::cell_size_factor:
        return report_cell_sizes(
            for_each_scene_and_mode(backend, [this](const DetectorScene& scene, const MeasuredOptions& options) {
              return all_cell_sizes(scene, options);
            }));
      case Sweep::scaling:
        return report_scaling(all_sizes(backend));
      case Sweep::ends:
        return report_ends(
            for_each_scene_and_mode(backend, [this](const DetectorScene& scene, const MeasuredOptions& options) {
              return at_both_ends_of_the_bus(scene, options);
            }));
      case Sweep::reuse:
        return report_reuse(
            for_each_scene_and_mode(backend, [this](const DetectorScene& scene, const MeasuredOptions& options) {
              return with_and_without_reuse(scene, options);
            }));
      case Sweep::threads:
        return report_threads(
            for_each_scene_and_mode(backend, [this](const DetectorScene& scene, const MeasuredOptions& options) {
              return with_more_and_more_threads(scene, options);
            }));
    }
  }

  Measurements for_each_scene_and_mode(
      Backend backend, const std::function<Measurements(const DetectorScene&, const MeasuredOptions&)>& measure_all) {
    Measurements all;
    for (const DetectorScene& scene : scenes_) {
      for (const MeasuredOptions& options : modes(backend)) {
        const Measurements some = measure_all(scene, options);
        all.insert(all.end(), some.begin(), some.end());
      }
    }
    return all;
  }

  std::vector<MeasuredOptions> modes(Backend backend) const {
    std::vector<MeasuredOptions> all;
    for (const Mode& mode : options_.modes) {
      MeasuredOptions options;
      options.backend = backend;
      options.detection = mode.detection;
      options.accuracy = mode.accuracy;
      all.push_back(options);
    }
    return all;
  }

  Measurement measure_one(const DetectorScene& scene, const MeasuredOptions& options) const {
    Measurement result = measure(scene, options, options_.repetitions);
    if (!scene.is_from_files && result.left_out.empty() && contact_count(result) == 0) {
      throw std::runtime_error(
          fmt::format("the scene {} of {} triangles has no {} contacts, so there is nothing to measure", scene.name,
                      scene.triangle_count(), detection_of(result)));
    }
    return result;
  }

  Measurements with_every_broad_phase(const DetectorScene& scene, MeasuredOptions options) const {
    Measurements results = {measure_one(scene, options)};
    options.is_paper = true;
    results.push_back(measure_one(scene, options));
    options.is_paper = false;
    options.subdivision = false;
    results.push_back(measure_one(scene, options));
    options.broad_phase = BroadPhase::uniform;
    const double expected_tests = estimate_uniform_tests(scene);
    if (expected_tests <= options_.most_tests) {
      results.push_back(measure_one(scene, options));
    } else {
      results.push_back(left_out(scene, options, fmt::format("about {:.1e} tests", expected_tests)));
    }
    return results;
  }

  Measurements all_cell_sizes(const DetectorScene& scene, MeasuredOptions options) const {
    Measurements results;
    for (const bool is_paper : {false, true}) {
      options.is_paper = is_paper;
      const int most = is_paper ? kMostTenthsPaper : kMostTenthsExact;
      for (int tenths = kLeastTenths; tenths <= most; tenths += kTenthsStep) {
        options.cell_size_factor = static_cast<float>(tenths) / 10.0F;
        results.push_back(measure_one(scene, options));
      }
    }
    return results;
  }

  /// Measures the largest scene first, so that there is memory for it.
  Measurements all_sizes(Backend backend) const {
    const double triangles_at_scale_1 = static_cast<double>(make_cloth_on_ball(1).triangle_count());
    Measurements results;
    for (double triangles = options_.most_triangles; triangles >= kLeastScalingTriangles; triangles /= kScalingFactor) {
      const DetectorScene scene = make_cloth_on_ball(triangles / triangles_at_scale_1);
      for (const MeasuredOptions& options : modes(backend)) results.push_back(measure_one(scene, options));
    }
    return results;
  }

  /// Measures with 1, 2, 4 and so on threads, and with all.
  Measurements with_more_and_more_threads(const DetectorScene& scene, const MeasuredOptions& options) const {
    const auto all = parallel::allowed_threads();
    Measurements results;
    for (std::size_t threads = 1; threads < 2 * all; threads *= 2) {
      const parallel::ThreadLimit limit(std::min(threads, all));
      results.push_back(measure_one(scene, options));
    }
    return results;
  }

  Measurements at_both_ends_of_the_bus(const DetectorScene& scene, MeasuredOptions options) const {
    Measurements results = {measure_one(scene, options)};
    options.on_device = true;
    results.push_back(measure_one(scene, options));
    return results;
  }

  /// Measures with resting positions, where kept pairs are reused, and with positions that move to and fro.
  Measurements with_and_without_reuse(const DetectorScene& scene, MeasuredOptions options) const {
    Measurements results;
    for (const bool rocks : {false, true}) {
      for (const bool reuses : {false, true}) {
        options.rocks = rocks;
        options.reuse_pairs = reuses;
        results.push_back(measure_one(scene, options));
      }
    }
    return results;
  }

  /// Checks that contacts are the same bytes for every backend and setting; `paper` may lose some.
  void compare_contacts(const Measurement& m) {
    if (!m.left_out.empty() || m.options.is_paper) return;
    const std::string what = fmt::format("{} of {} triangles, {}{}", m.scene, m.statistics.triangles, detection_of(m),
                                         m.options.rocks ? ", to and fro" : "");
    const auto [first, is_new] = checksums_.try_emplace(what, m.checksum);
    if (first->second != m.checksum && error_.empty()) {
      error_ = fmt::format(
          "{}: not all measurements found the same contacts, which is an error in softcd; compare "
          "contacts_checksum in the file of --json",
          what);
    }
  }

  void report_stages(const Measurements& measurements) {
    Table times({"scene", "detection", "ms", "volumes", "subdivision", "assignment", "sort", "tests", "features",
                 "narrow", "transfer"},
                2);
    Table counts({"scene", "detection", "triangles", "split", "children", "big", "entries", "cells", "tests", "pairs",
                  "VT cand.", "EE cand.", "VT", "EE", "MB"},
                 2);
    for (const Measurement& m : measurements) {
      if (!m.left_out.empty()) {
        times.add({m.scene, detection_of(m), m.left_out});
        continue;
      }
      const Statistics& s = m.statistics;
      const StageTimes& ms = s.ms;
      std::vector<std::string> row = {m.scene, detection_of(m)};
      for (const double time : {work_ms(m), ms.volumes, ms.subdivision, ms.assignment, ms.sort, ms.tests, ms.features,
                                ms.narrow, ms.transfer}) {
        row.push_back(decimals(time, 3));
      }
      times.add(row);
      row = {m.scene, detection_of(m)};
      for (const std::uint64_t count :
           {s.triangles, s.split_triangles, s.children, s.big_triangles, s.entries, s.cells, s.tests, s.triangle_pairs,
            s.vt_candidates, s.ee_candidates, s.vt_contacts, s.ee_contacts}) {
        row.push_back(fmt::to_string(count));
      }
      row.push_back(megabytes(s.peak_bytes));
      counts.add(row);
    }
    add_section("Time per stage",
                "Milliseconds. `ms` is the detection without `transfer`; the stages leave out what "
                "the host prepares.",
                times, measurements);
    add_section("Work per stage", "Counts of one detection, and the most memory used.", counts, measurements);
    record(measurements);
  }

  void report_subdivision(const Measurements& measurements) {
    Table table(
        {"scene", "detection", "broad phase", "children/triangles", "tests", "tests/exact", "contacts", "ms", "MB"}, 3);
    double exact_tests = 0;
    for (const Measurement& m : measurements) {
      if (!m.left_out.empty()) {
        table.add({m.scene, detection_of(m), broad_phase_and_subdivision_of(m), "", m.left_out});
        continue;
      }
      const auto tests = static_cast<double>(m.statistics.tests);
      if (is_exact(m) && m.options.subdivision) exact_tests = tests;
      table.add({m.scene, detection_of(m), broad_phase_and_subdivision_of(m), decimals(children_ratio(m), 3),
                 fmt::to_string(m.statistics.tests), decimals(tests / exact_tests, 2), fmt::to_string(contact_count(m)),
                 decimals(work_ms(m), 3), megabytes(m.statistics.peak_bytes)});
    }
    add_section("Virtual subdivision",
                fmt::format("Rows that would need more than {:.0e} tests are left out.", options_.most_tests), table,
                measurements);
    record(measurements);
  }

  void report_cell_sizes(const Measurements& measurements) {
    Table table(
        {"scene", "detection", "broad phase", "cell_size_factor", "children/triangles", "entries", "tests", "ms"}, 3);
    for (const Measurement& m : measurements) {
      if (!m.left_out.empty()) {
        table.add({m.scene, detection_of(m), broad_phase_of(m), "", "", "", m.left_out});
        continue;
      }
      table.add({m.scene, detection_of(m), broad_phase_of(m),
                 decimals(static_cast<double>(m.options.cell_size_factor), 1), decimals(children_ratio(m), 3),
                 fmt::to_string(m.statistics.entries), fmt::to_string(m.statistics.tests), decimals(work_ms(m), 3)});
    }
    add_section("Cell size", "A cell is cell_size_factor mean radii wide for `exact`, three times as wide for `paper`.",
                table, measurements);
    record(measurements);
  }

  void report_scaling(const Measurements& measurements) {
    Table table({"scene", "detection", "triangles", "contacts", "ms", "transfer", "ms per million", "MB"}, 2);
    for (const Measurement& m : measurements) {
      const Statistics& s = m.statistics;
      if (!m.left_out.empty()) {
        table.add({m.scene, detection_of(m), fmt::to_string(s.triangles), "", m.left_out});
        continue;
      }
      table.add({m.scene, detection_of(m), fmt::to_string(s.triangles), fmt::to_string(contact_count(m)),
                 decimals(work_ms(m), 3), decimals(s.ms.transfer, 3),
                 decimals(work_ms(m) / static_cast<double>(s.triangles) * 1e6, 2), megabytes(s.peak_bytes)});
    }
    add_section("Size", "Milliseconds; `ms` is the detection without `transfer`.", table, measurements);
    record(measurements);
  }

  void report_ends(const Measurements& measurements) {
    Table table({"scene", "detection", "ends", "triangles", "contacts", "wall ms", "ms"}, 3);
    for (const Measurement& m : measurements) {
      const char* const ends = m.options.on_device ? "device" : "host";
      if (!m.left_out.empty()) {
        table.add({m.scene, detection_of(m), ends, "", "", m.left_out});
        continue;
      }
      table.add({m.scene, detection_of(m), ends, fmt::to_string(m.statistics.triangles),
                 fmt::to_string(contact_count(m)), decimals(m.wall_ms, 3), decimals(work_ms(m), 3)});
    }
    add_section("Ends",
                "Where positions and contacts are. Milliseconds; `wall ms` is what the caller waits for, `ms` the "
                "detection without `transfer`.",
                table, measurements);
    record(measurements);
  }

  void report_reuse(const Measurements& measurements) {
    Table table({"scene", "detection", "positions", "pairs", "contacts", "tests", "wall ms", "ms", "MB"}, 4);
    for (const Measurement& m : measurements) {
      const char* const positions = m.options.rocks ? "to and fro" : "the same";
      const char* const pairs = !m.options.reuse_pairs ? "fresh" : m.statistics.reused_pairs ? "kept" : "kept in vain";
      if (!m.left_out.empty()) {
        table.add({m.scene, detection_of(m), positions, pairs, "", "", "", m.left_out});
        continue;
      }
      table.add({m.scene, detection_of(m), positions, pairs, fmt::to_string(contact_count(m)),
                 fmt::to_string(m.statistics.tests), decimals(m.wall_ms, 3), decimals(work_ms(m), 3),
                 megabytes(m.statistics.peak_bytes)});
    }
    add_section("Reuse",
                "Detection after detection, without and with reuse of pairs of triangles; `pairs` says what the last "
                "one has tested. Milliseconds; `wall ms` is what the caller waits for, `ms` the detection without "
                "`transfer`.",
                table, measurements);
    record(measurements);
  }

  void report_threads(const Measurements& measurements) {
    Table table({"scene", "detection", "threads", "ms", "speed-up"}, 2);
    double one_thread_ms = 0;
    for (const Measurement& m : measurements) {
      if (!m.left_out.empty()) {
        table.add({m.scene, detection_of(m), "", m.left_out});
        continue;
      }
      if (m.threads == 1) one_thread_ms = work_ms(m);
      table.add({m.scene, detection_of(m), fmt::to_string(m.threads), decimals(work_ms(m), 3),
                 decimals(one_thread_ms / work_ms(m), 2)});
    }
    add_section("Threads", "Milliseconds; `ms` is the detection without `transfer`.", table, measurements);
    record(measurements);
  }

  void add_section(const std::string& title, const std::string& note, const Table& table,
                   const Measurements& measurements) {
    const char* backend = demo::name_of(measurements.front().options.backend);
    const std::string section = fmt::format("### {}, {}\n\n{}\n\n{}\n", title, backend, note, table.text());
    fmt::print("{}", section);
    std::fflush(stdout);
    report_ += section;
  }

  void record(const Measurements& measurements) {
    for (const Measurement& m : measurements) {
      json_["rows"].push_back(to_json(sweep_, m));
      compare_contacts(m);
    }
  }

  const DetectorOptions& options_;
  Sweep sweep_ = Sweep::stages;
  std::vector<DetectorScene> scenes_;
  std::string report_;
  std::map<std::string, std::uint64_t> checksums_;  ///< of the contacts, by scene and mode
  std::string error_;                               ///< the first difference between checksums; empty: none
  nlohmann::ordered_json json_ = describe_run("detector", options_.machine);
};

}  // namespace

void add_detector(CLI::App& app, DetectorOptions& options) {
  CLI::App* command = app.add_subcommand(
      "detector",
      "Measures the detector alone: discrete detection in float32 (dcd fast; contacts within a tenth of an edge) and\n"
      "continuous detection in float64 (ccd precise; collisions), vertex-triangle and edge-edge, on one step each of\n"
      "generated scenes and of meshes from files. Median times in milliseconds");
  demo::add_choices(
      *command, "--scene", kScenes, options.scenes,
      "A cloth in a funnel (18K triangles), a cloth on a ball (92K), 450 balls and 4 cones (144K), 1,000\n"
      "boxes of 12 triangles. Default: the first three");
  CLI::Option* t0 =
      command->add_option("--t0", options.first_frame, "Instead: a mesh at the start of a step, PLY or OBJ")
          ->option_text("FILE");
  CLI::Option* t1 = command->add_option("--t1", options.second_frame, "Its triangles at the end")->option_text("FILE");
  t0->needs(t1);
  t1->needs(t0);
  command
      ->add_option("--step", options.step_folders,
                   "Also recorded steps: folders that contain a folder frames with two meshes, like the sample data of "
                   "Scalable CCD")
      ->option_text("DIR...")
      ->check(CLI::ExistingDirectory);
  demo::add_choices(*command, "--mode", kModes, options.modes,
                    "The kind of detection, and the narrow phase's arithmetic");
  command->add_option("--scale", options.scale, "Multiplies the generated scenes' triangle counts, roughly")
      ->option_text("S [1]")
      ->check(CLI::Range(0.01, 1000.0));
  demo::add_choices(
      *command, "--sweep", kSweeps, options.sweeps,
      "stages: time and work per stage. subdivision: with and without virtual subdivision, and the\n"
      "uniform grid. cell_size_factor: smaller and larger cells, of broad phases exact and paper. scaling:\n"
      "cloth-on-ball from about 10K triangles to --most. threads: on 1, 2, 4 ... threads of the CPU. ends: positions "
      "and\n"
      "contacts in the host's memory and in the device's (with --backend cuda). reuse: without and with\n"
      "pairs that earlier detections have found, of the same step and of one to and fro");
  demo::add_choices(*command, "--backend", options.backends, "The backends to measure, one after the other");
  command
      ->add_option("--repeat", options.repetitions,
                   fmt::format("Measured detections, after 3 to warm up; fewer where they take more than {:.0f} s",
                               kMostSeconds))
      ->option_text("N [50]")
      ->check(CLI::Range(1, 1000000));
  command->add_option("--most", options.most_triangles, "Triangles of the largest scene of --sweep scaling")
      ->option_text("N [1e6]")
      ->check(CLI::Range(kLeastScalingTriangles, 1e8));
  command
      ->add_option("--most-tests", options.most_tests,
                   "Skip measurements that would enumerate more pairs of triangles, by an estimate: those of\n"
                   "--sweep subdivision with a grid for the largest triangle")
      ->option_text("N [2e10]")
      ->check(CLI::PositiveNumber);
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the tables as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure as JSON; times in milliseconds, memory in bytes")
      ->option_text("FILE");
  command->add_option("--csv", options.csv_file, "Write the same as CSV, one row a measurement")->option_text("FILE");
  command->callback([&options] { Benchmark(options).run(); });
}

}  // namespace softcd::benchmarks

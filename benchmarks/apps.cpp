#include "apps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "app_list.hpp"
#include "command_line/choices.hpp"
#include "report.hpp"
#include "timing.hpp"

// Compares apps with softcd and with Bullet alone: intersections, energy, lost bodies, and the time of a step.

namespace softcd::benchmarks {
namespace {

using demo::name_of;

constexpr std::array<demo::Choice<AppWorldKind>, 3> kAppWorlds = {{{"soft-rigid", AppWorldKind::soft_rigid},
                                                                   {"soft-multi-body", AppWorldKind::soft_multi_body},
                                                                   {"deformable", AppWorldKind::deformable}}};
constexpr std::array<demo::Choice<AppDetection>, 4> kAppDetections = {{{"bullet", AppDetection::bullet},
                                                                       {"fast", AppDetection::fast},
                                                                       {"balanced", AppDetection::balanced},
                                                                       {"safe", AppDetection::safe}}};

std::optional<bullet::Settings> settings_of(AppDetection detection, Backend backend) {
  bullet::Settings settings;
  switch (detection) {
    case AppDetection::bullet:
      return std::nullopt;
    case AppDetection::fast:
      settings = bullet::Settings::fast();
      break;
    case AppDetection::balanced:
      settings = bullet::Settings::balanced();
      break;
    case AppDetection::safe:
      settings = bullet::Settings::safe();
      break;
  }
  settings.backend = backend;
  return settings;
}

struct AppRun {
  const App* app = nullptr;
  AppWorldKind world = AppWorldKind::soft_rigid;
  AppDetection detection = AppDetection::bullet;
  int iterations = 1;
  bool is_driven = false;  ///< whether the app itself moves something
  int frames = 0;
  int frames_with_crossings = 0;
  std::size_t most_crossings = 0, crossings_at_end = 0;
  double start_energy = 0, most_energy = 0;  ///< kinetic, J
  double start_mechanical = 0;               ///< kinetic energy and potential energy in gravity, J
  double gained_energy = 0;                  ///< greatest rise of the mechanical energy above the start's, J
  double farthest = 0;                       ///< largest distance of a node or a rigid body from the origin at any time
  std::size_t lost_bodies = 0;
  double step_milliseconds = 0;  ///< median
};

void see_frame(AppWorld& world, AppRun& run) {
  ++run.frames;
  run.crossings_at_end = world.count_crossings();
  run.most_crossings = std::max(run.most_crossings, run.crossings_at_end);
  run.frames_with_crossings += run.crossings_at_end > 0 ? 1 : 0;
  const AppMotion motion = world.motion();
  if (!(motion.kinetic_energy <= run.most_energy)) run.most_energy = motion.kinetic_energy;
  if (!(motion.farthest <= run.farthest)) run.farthest = motion.farthest;
  const double gained = motion.kinetic_energy + motion.potential_energy - run.start_mechanical;
  if (!(gained <= run.gained_energy)) run.gained_energy = gained;
}

AppRun simulate(const App& app, AppWorldKind kind, AppDetection detection, int iterations, int start,
                const AppsOptions& options) {
  AppWorld world(kind, settings_of(detection, options.backend), iterations);
  const AppDrive drive = app.build(world);
  if (start > 0) world.shift_bodies(static_cast<unsigned>(start));
  AppRun run;
  run.app = &app;
  run.world = kind;
  run.detection = detection;
  run.iterations = iterations;
  run.is_driven = drive != nullptr;
  const AppMotion start_motion = world.motion();
  run.start_energy = start_motion.kinetic_energy;
  run.start_mechanical = start_motion.kinetic_energy + start_motion.potential_energy;
  const int parts = world.steps_per_frame() * options.splits;
  const btScalar seconds = AppWorld::kFrame / btScalar(parts);
  const double duration = options.seconds > 0 ? options.seconds : app.seconds;
  const int frames = std::max(2, static_cast<int>(std::lround(duration / double(AppWorld::kFrame))));
  std::vector<double> times;
  for (int step = 0; step < frames * parts; ++step) {
    if (drive) drive(btScalar(step + 1) * seconds, seconds);
    times.push_back(milliseconds_of([&] { world.step(seconds); }));
    if ((step + 1) % parts == 0) see_frame(world, run);
  }
  run.lost_bodies = world.count_lost(app.lowest);
  run.step_milliseconds = median_without_first(times);
  return run;
}

/// Returns the median of each figure; of an even number, the upper one.
AppRun median_of(std::vector<AppRun> runs) {
  AppRun result = runs.front();
  const auto set_median = [&](auto AppRun::*figure) {
    // NaN counts as largest.
    const auto is_less = [&](const AppRun& a, const AppRun& b) {
      return a.*figure < b.*figure || (a.*figure == a.*figure && b.*figure != b.*figure);
    };
    const auto middle = runs.begin() + static_cast<std::ptrdiff_t>(runs.size() / 2);
    std::nth_element(runs.begin(), middle, runs.end(), is_less);
    result.*figure = (*middle).*figure;
  };
  set_median(&AppRun::frames_with_crossings);
  set_median(&AppRun::most_crossings);
  set_median(&AppRun::crossings_at_end);
  set_median(&AppRun::start_energy);
  set_median(&AppRun::most_energy);
  set_median(&AppRun::gained_energy);
  set_median(&AppRun::farthest);
  set_median(&AppRun::lost_bodies);
  set_median(&AppRun::step_milliseconds);
  return result;
}

AppRun simulate_starts(const App& app, AppWorldKind kind, AppDetection detection, int iterations,
                       const AppsOptions& options) {
  std::vector<AppRun> runs;
  runs.reserve(static_cast<std::size_t>(options.starts));
  for (int start = 0; start < options.starts; ++start) {
    runs.push_back(simulate(app, kind, detection, iterations, start, options));
  }
  return median_of(std::move(runs));
}

/// Two energies count as the same if they differ by less than these shares: of the gain, and of the kinetic energy.
constexpr double kSameGain = 0.1;
constexpr double kSameEnergy = 0.01;

/// Returns the figures in which a run is worse than Bullet's run of the same app. Kinetic energy is none of them: it
/// also says how freely bodies fall, and grows if a figure takes along the cloth that it passed through before. The
/// mechanical energy counts where the app itself moves nothing. A run of Bullet's that ends at positions that are not
/// numbers is never the better one.
std::vector<std::string> worse_figures(const AppRun& run, const AppRun& bullet) {
  std::vector<std::string> figures;
  if (!std::isfinite(bullet.most_energy)) return figures;
  if (run.frames_with_crossings > bullet.frames_with_crossings) figures.emplace_back("crossings");
  if (run.lost_bodies > bullet.lost_bodies) figures.emplace_back("lost");
  const double allowed_gain = (1 + kSameGain) * bullet.gained_energy + kSameEnergy * bullet.most_energy;
  if (!run.is_driven && !(run.gained_energy <= allowed_gain)) figures.emplace_back("energy");
  return figures;
}

/// Counts the rows of each preset that are worse than Bullet's.
struct Verdicts {
  std::array<int, kAppDetections.size()> rows{}, worse{};

  void add(const AppRun& run, bool is_worse) {
    ++rows[static_cast<std::size_t>(run.detection)];
    worse[static_cast<std::size_t>(run.detection)] += is_worse ? 1 : 0;
  }
  std::string text() const {
    std::string result;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i] == 0) continue;
      result += fmt::format("{}: {} of {} rows worse than Bullet alone\n", kAppDetections[i].name, worse[i], rows[i]);
    }
    return result.empty() ? result : "\n" + result;
  }
};

nlohmann::ordered_json to_json(const AppRun& run) {
  return {{"app", run.app->name},
          {"world", name_of(kAppWorlds, run.world)},
          {"detection", name_of(kAppDetections, run.detection)},
          {"iterations", run.iterations},
          {"frames", run.frames},
          {"frames_with_crossings", run.frames_with_crossings},
          {"most_crossings", run.most_crossings},
          {"crossings_at_end", run.crossings_at_end},
          {"start_energy", run.start_energy},
          {"most_energy", run.most_energy},
          {"gained_energy", run.gained_energy},
          {"farthest", run.farthest},
          {"lost_bodies", run.lost_bodies},
          {"step_milliseconds", run.step_milliseconds}};
}

std::vector<std::string> to_row(const AppRun& run) {
  return {run.app->name,
          name_of(kAppWorlds, run.world),
          name_of(kAppDetections, run.detection),
          fmt::to_string(run.iterations),
          fmt::format("{} of {}", run.frames_with_crossings, run.frames),
          fmt::to_string(run.most_crossings),
          fmt::to_string(run.crossings_at_end),
          fmt::format("{:.3g}", run.start_energy),
          fmt::format("{:.3g}", run.most_energy),
          fmt::format("{:.3g}", run.gained_energy),
          fmt::format("{:.3g}", run.farthest),
          fmt::to_string(run.lost_bodies),
          fmt::format("{:.3f}", run.step_milliseconds)};
}

std::string in_words(const std::optional<std::vector<std::string>>& worse) {
  if (!worse.has_value()) return "";
  return worse->empty() ? "no" : fmt::format("{}", fmt::join(*worse, ", "));
}

void run(const AppsOptions& options) {
  Table table({"app", "world", "detection", "iterations", "frames with", "most", "at the end", "J at start", "J, most",
               "J gained", "farthest", "lost", "ms", "worse"},
              3);
  nlohmann::ordered_json json = describe_run("apps", options.machine);
  Verdicts verdicts;
  for (const App& app : apps()) {
    const bool is_wanted =
        options.apps.empty() || std::find(options.apps.begin(), options.apps.end(), app.name) != options.apps.end();
    if (!is_wanted) continue;
    for (const AppWorldKind world : options.worlds) {
      for (const int iterations : options.iterations) {
        // Bullet's deformable solver has no position iterations.
        if (world == AppWorldKind::deformable && iterations != options.iterations.front()) continue;
        std::optional<AppRun> bullet;
        for (const AppDetection detection : options.detections) {
          const AppRun result = simulate_starts(app, world, detection, iterations, options);
          std::optional<std::vector<std::string>> worse;
          if (detection == AppDetection::bullet) {
            bullet = result;
          } else if (bullet.has_value()) {
            worse = worse_figures(result, *bullet);
            verdicts.add(result, !worse->empty());
          }
          std::vector<std::string> row = to_row(result);
          row.push_back(in_words(worse));
          fmt::print(stderr, "{}\n", fmt::join(row, " "));
          table.add(row);
          json["apps"].push_back(to_json(result));
          if (worse.has_value()) json["apps"].back()["worse"] = *worse;
        }
      }
    }
  }
  const std::string report = fmt::format(
      "### Apps\n\n`frames with`: frames of 1/60 s that end with an edge through a triangle, in exact arithmetic; "
      "`most` "
      "edges in one frame, and `at the end`. J: kinetic energy. `J gained`: greatest rise of the kinetic energy plus "
      "that in gravity above the start's, which the app's own motion or Bullet's springs may cause, too. `farthest`: "
      "the largest distance of anything from the origin, m. `lost`: free bodies that have fallen through. ms: median "
      "of a step. `worse`: the figures that are higher than with Bullet alone, if that ran before: frames with "
      "crossings, lost bodies, and energy, which is `J gained` in apps that move nothing themselves, more than a tenth "
      "above Bullet's.\n\n{}{}\n",
      table.text(), verdicts.text());
  fmt::print("{}", report);
  if (!options.markdown_file.empty()) write_file(options.markdown_file, report);
  if (!options.json_file.empty()) write_json(options.json_file, json);
}

std::string list_of_apps() {
  std::string list;
  for (const App& app : apps()) list += fmt::format("  {:<24} {}\n", app.name, app.description);
  return list;
}

}  // namespace

void add_apps(CLI::App& app, AppsOptions& options) {
  CLI::App* command = app.add_subcommand(
      "apps",
      "Compares small apps with Bullet alone and with softcd's presets: intersections, energy, lost bodies, and\n"
      "the time of a step");
  command->add_option("--app", options.apps, "Several by commas")
      ->option_text("APP [all]")
      ->delimiter(',')
      ->check([](const std::string& name) {
        const bool is_known = std::any_of(apps().begin(), apps().end(), [&](const App& a) { return a.name == name; });
        return is_known ? std::string() : fmt::format("there is no app '{}'; there are\n{}", name, list_of_apps());
      });
  demo::add_choices(*command, "--world", kAppWorlds, options.worlds, "Bullet's worlds, one after the other");
  demo::add_choices(*command, "--detection", kAppDetections, options.detections,
                    "Bullet's own detection, or a preset of softcd's");
  command->add_option("--iterations", options.iterations, "Position iterations of the soft bodies; several by commas")
      ->option_text("N [1,4]")
      ->delimiter(',')
      ->check(CLI::Range(1, 1000));
  command
      ->add_option(
          "--starts", options.starts,
          "Runs of each app. The first is unchanged; in the others bodies are shifted by up to 1 mm. A row has the\n"
          "median of each figure")
      ->option_text("N [1]")
      ->check(CLI::Range(1, 1000));
  command->add_option("--seconds", options.seconds, "Simulated seconds of each app")
      ->option_text("S [its own]")
      ->check(CLI::Range(0.001, 10000.0));
  command
      ->add_option(
          "--splits", options.splits,
          "Splits each step into equal parts. It tells what Bullet's solver does to an app in long steps from\n"
          "what the contacts do")
      ->option_text("N [1]")
      ->check(CLI::Range(1, 1000));
  demo::add_choice(*command, "--backend", options.backend, "softcd's backend");
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the table as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure of every run")->option_text("FILE");
  command->footer("Apps:\n" + list_of_apps() + "\n" + app.get_footer());
  command->callback([&options] { run(options); });
}

}  // namespace softcd::benchmarks

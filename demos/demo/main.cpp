#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "command_line.hpp"
#include "command_line/choices.hpp"
#include "measurement.hpp"
#include "picture.hpp"
#include "png_file.hpp"
#include "softcd/softcd.hpp"

namespace softcd::demo {
namespace {

constexpr long kStepsPerFrame = 4;

// What is going on, in one line that is overwritten, for people at a terminal.
class Progress {
 public:
  void show(const std::string& text) const {
    if (is_terminal_) fmt::print(stderr, "\r\x1b[K{}", text);
  }
  void clear() const { show(""); }

 private:
  bool is_terminal_ = isatty(STDERR_FILENO) != 0;
};

std::size_t count_triangles(const Scene& scene) {
  std::size_t count = 0;
  for (const Surface& surface : scene.surfaces()) count += static_cast<std::size_t>(surface.body->m_faces.size());
  return count;
}

void print_head(const DemoCommand& command, const Scene& scene) {
  fmt::print("{}: {} triangles, {} world, collision {}", command.scene, count_triangles(scene),
             name_of(command.options.world), name_of(command.options.collision));
  if (const CollisionPipeline* pipeline = scene.simulation().pipeline()) {
    fmt::print(", detection {} on {}", name_of(kDetections, command.options.settings.detection),
               name_of(kBackends, pipeline->backend()));
  }
  fmt::print("\n{:>6}  {:>9}  {:>12}  {:>9}  {:>11}\n", "time s", "step ms", "detection ms", "contacts", "penetrating");
}

void print_row(const Row& row) {
  const std::string detection = std::isnan(row.detection_ms) ? "-" : fmt::format("{:.2f}", row.detection_ms);
  fmt::print("{:>6.2f}  {:>9.2f}  {:>12}  {:>9}  {:>11}\n", row.until, row.step_ms, detection, row.contacts,
             row.penetrating);
  std::fflush(stdout);
}

void print_summary(const Measurement& measurement, long steps) {
  fmt::print("{} steps in {:.1f} s: first {:.1f} ms, median {:.2f} ms; at most {} penetrating vertices\n", steps,
             measurement.total_seconds, measurement.first_step_ms, measurement.median_step_ms,
             measurement.most_penetrating);
}

nlohmann::ordered_json to_json(const DemoCommand& command, const Scene& scene, const Measurement& measurement) {
  nlohmann::ordered_json json = {{"scene", command.scene},
                                 {"triangles", count_triangles(scene)},
                                 {"world", name_of(command.options.world)},
                                 {"collision", name_of(command.options.collision)},
                                 {"detection", name_of(kDetections, command.options.settings.detection)},
                                 {"steps", command.steps},
                                 {"time_step", double(Scene::kTimeStep)},
                                 {"first_step_ms", measurement.first_step_ms},
                                 {"median_step_ms", measurement.median_step_ms},
                                 {"total_seconds", measurement.total_seconds},
                                 {"most_penetrating", measurement.most_penetrating}};
  if (const CollisionPipeline* pipeline = scene.simulation().pipeline())
    json["backend"] = name_of(kBackends, pipeline->backend());
  json["rows"] = nlohmann::ordered_json::array();
  for (const Row& row : measurement.rows) {
    nlohmann::ordered_json entry = {{"until", row.until}, {"step_ms", row.step_ms}};
    if (!std::isnan(row.detection_ms)) entry["detection_ms"] = row.detection_ms;
    entry["contacts"] = row.contacts;
    entry["penetrating"] = row.penetrating;
    json["rows"].push_back(entry);
  }
  return json;
}

void write_text(const std::string& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw std::runtime_error(fmt::format("{}: cannot be written (does its folder exist?)", file));
}

void run(DemoCommand command) {
  const Progress progress;
  command.options.settings.log = [&progress](LogLevel level, std::string_view text) {
    if (level != LogLevel::warning) return;
    progress.clear();
    fmt::print(stderr, "warning: {}\n", text);
  };
  if (!command.record_folder.empty()) std::filesystem::create_directories(command.record_folder);
  progress.show("building the scene");
  const std::unique_ptr<Scene> scene = make_scene(command.scene, command.options);
  progress.clear();
  print_head(command, *scene);

  Callbacks callbacks;
  callbacks.on_step = [&](long step) {
    progress.show(fmt::format("step {} of {}", step, command.steps));
    if (command.record_folder.empty() || step % kStepsPerFrame != 0) return;
    const auto file = fmt::format("frame-{:04}.png", step / kStepsPerFrame - 1);
    write_png(std::filesystem::path(command.record_folder) / file, take_picture(*scene));
  };
  callbacks.on_row = [&](const Row& row) {
    progress.clear();
    print_row(row);
  };
  const Measurement measurement = measure(*scene, command.steps, callbacks);
  print_summary(measurement, command.steps);

  const std::filesystem::path picture_file = command.picture_file;
  if (picture_file.has_parent_path()) std::filesystem::create_directories(picture_file.parent_path());
  write_png(picture_file, take_picture(*scene));
  fmt::print("picture: {}\n", command.picture_file);
  if (!command.json_file.empty()) write_text(command.json_file, to_json(command, *scene, measurement).dump(2) + "\n");
}

}  // namespace
}  // namespace softcd::demo

int main(int argc, char** argv) {
  using namespace softcd::demo;
  try {
    const ParsedCommandLine parsed = parse_command_line(argc, argv);
    if (!parsed.command) return parsed.exit_code;
    run(*parsed.command);
    return 0;
  } catch (const std::invalid_argument& error) {
    fmt::print(stderr, "softcd-demo: {}\n", error.what());
    return kExitWrongInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "softcd-demo: {}\n", error.what());
    return kExitFailed;
  }
}

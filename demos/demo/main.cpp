#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "command_line.hpp"
#include "command_line/choices.hpp"
#include "frame_writer.hpp"
#include "measurement.hpp"
#include "png_file.hpp"
#include "progress.hpp"
#include "softcd/softcd.hpp"
#include "viewer/viewer.hpp"

namespace softcd::demo {
namespace {

constexpr int kStepsPerSecond = 120;

void print_head(const DemoCommand& command, const Scene& scene) {
  fmt::print("{}: {} triangles, {} world, collision {}", command.scene, scene.count_triangles(),
             name_of(command.options.world), name_of(command.options.collision));
  if (const bullet::WorldDetection* detection = scene.simulation().detection()) {
    fmt::print(", detection {} on {}", name_of(command.options.settings.detection),
               name_of(detection->contact_report().backend()));
  }
  fmt::print("\n{:>6}  {:>9}  {:>12}  {:>9}  {:>11}  {:>18}\n", "time s", "step ms", "detection ms", "contacts",
             "penetrating", "intersecting edges");
}

void print_row(const Row& row) {
  const std::string detection = std::isnan(row.detection_ms) ? "-" : fmt::format("{:.2f}", row.detection_ms);
  fmt::print("{:>6.2f}  {:>9.2f}  {:>12}  {:>9}  {:>11}  {:>18}\n", row.until, row.step_ms, detection, row.contacts,
             row.penetration.vertices, row.penetration.edges);
  std::fflush(stdout);
}

void print_summary(const Measurement& measurement, long steps) {
  fmt::print(
      "\n{} steps in {:.1f} s: first {:.1f} ms, median {:.2f} ms; at most {} penetrating vertices and {} "
      "intersecting edges\n",
      steps, measurement.total_seconds, measurement.first_step_ms, measurement.median_step_ms,
      measurement.most_penetration.vertices, measurement.most_penetration.edges);
  if (std::isnan(measurement.rows.front().detection_ms)) return;
  const double step_ms = 1000 * measurement.total_seconds / static_cast<double>(steps);
  const auto print_part = [&](const char* part, double ms) {
    fmt::print("{:<44}{:>9.2f}{:>8.0f} %\n", part, ms, 100 * ms / step_ms);
  };
  const double contacts = measurement.total_profile.contacts / static_cast<double>(steps);
  const double crossings = measurement.total_profile.crossings / static_cast<double>(steps);
  fmt::print("{:<44}{:>9}{:>10}\n", "mean step", "ms", "share");
  print_part("softcd: contacts", contacts);
  print_part("softcd: preventing what would pass through", crossings);
  print_part("Bullet", step_ms - contacts - crossings);
}

nlohmann::ordered_json to_json(const DemoCommand& command, const Scene& scene, const Measurement& measurement) {
  nlohmann::ordered_json json = {{"scene", command.scene},
                                 {"triangles", scene.count_triangles()},
                                 {"world", name_of(command.options.world)},
                                 {"collision", name_of(command.options.collision)},
                                 {"detection", name_of(command.options.settings.detection)},
                                 {"steps", command.steps},
                                 {"time_step", double(scene.time_step())},
                                 {"first_step_ms", measurement.first_step_ms},
                                 {"median_step_ms", measurement.median_step_ms},
                                 {"total_seconds", measurement.total_seconds},
                                 {"contacts_seconds", measurement.total_profile.contacts / 1000},
                                 {"crossings_seconds", measurement.total_profile.crossings / 1000},
                                 {"most_penetrating_vertices", measurement.most_penetration.vertices},
                                 {"most_intersecting_edges", measurement.most_penetration.edges}};
  if (const bullet::WorldDetection* detection = scene.simulation().detection())
    json["backend"] = name_of(detection->contact_report().backend());
  json["rows"] = nlohmann::ordered_json::array();
  for (const Row& row : measurement.rows) {
    nlohmann::ordered_json entry = {{"until", row.until}, {"step_ms", row.step_ms}};
    if (!std::isnan(row.detection_ms)) entry["detection_ms"] = row.detection_ms;
    entry["contacts"] = row.contacts;
    entry["penetrating_vertices"] = row.penetration.vertices;
    entry["intersecting_edges"] = row.penetration.edges;
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

/// Writes a picture of the window into a new file here, and returns its name.
std::string save_picture(const Image& image) {
  for (int number = 1;; ++number) {
    std::string file = fmt::format("softcd-demo-{}.png", number);
    if (std::filesystem::exists(file)) continue;
    write_png(file, image);
    return file;
  }
}

void view(const DemoCommand& command) {
  ViewerOptions options;
  options.save_picture = save_picture;
  options.frames = command.view_frames;
  options.overlays = command.pictures.overlays;
  if (!command.screenshot_file.empty()) {
    options.take_screenshot = [&](const Image& image) { write_png(command.screenshot_file, image); };
  }
  run_viewer(command.scene, command.options, options);
}

// Makes the drawer of the command's pictures. Returns null, with the reason in `problem`, where the command requires no
// picture and none can be drawn.
std::unique_ptr<PictureTaker> make_picture_taker(const DemoCommand& command, std::string& problem) {
  try {
    return std::make_unique<PictureTaker>(command.pictures);
  } catch (const std::runtime_error& error) {
    if (!command.picture_file.empty() || !command.record.empty()) throw;
    problem = error.what();
    return nullptr;
  }
}

void write_last_picture(const std::filesystem::path& file, const Image& image) {
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  write_png(file, image);
  fmt::print("picture: {}\n", file.string());
}

void run(DemoCommand command) {
  Progress progress;
  command.options.settings.log = [&progress](LogLevel level, std::string_view text) {
    if (level != LogLevel::warning) return;
    progress.clear();
    fmt::print(stderr, "warning: {}\n", text);
  };
  if (command.view) {
    view(command);
    return;
  }
  std::string no_picture;
  const std::unique_ptr<PictureTaker> pictures = make_picture_taker(command, no_picture);
  FrameWriter frames(pictures.get(), command.record, command.mesh_files, kStepsPerSecond / command.frame_steps);
  progress.show("building the scene");
  const std::unique_ptr<Scene> scene = make_scene(command.scene, command.options);
  progress.clear();
  print_head(command, *scene);

  const std::filesystem::path step_folder = command.exported_step.second;
  const auto export_step = [&](long steps_done) {
    if (command.exported_step.first == 0) return;
    if (steps_done == command.exported_step.first - 1) write_mesh(step_folder / "t0.ply", *scene);
    if (steps_done == command.exported_step.first) write_mesh(step_folder / "t1.ply", *scene);
  };
  export_step(0);
  progress.start();

  Callbacks callbacks;
  callbacks.on_step = [&](long step) {
    progress.show_step(step, command.steps);
    if (step % command.frame_steps == 0) frames.write(*scene);
    export_step(step);
  };
  callbacks.on_row = [&](const Row& row) {
    progress.clear();
    print_row(row);
  };
  const Measurement measurement = measure(*scene, command.steps, callbacks);
  print_summary(measurement, command.steps);
  frames.finish();

  if (pictures) {
    write_last_picture(command.picture_file.empty() ? kDefaultPicture : command.picture_file, pictures->take(*scene));
  } else {
    fmt::print("{}\n", no_picture);
  }
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

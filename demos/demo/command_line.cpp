#include "command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <vector>

#include "command_line/option_flags.hpp"
#include "command_line/world_choices.hpp"
#include "mesh_tools/mesh_io.hpp"
#include "softcd/fields/settings.hpp"

namespace softcd::demo {
namespace {

constexpr std::array<Choice<bool OverlayChoice::*>, 5> kOverlays = {{{"wire", &OverlayChoice::wire},
                                                                     {"contacts", &OverlayChoice::contacts},
                                                                     {"cells", &OverlayChoice::cells},
                                                                     {"children", &OverlayChoice::children},
                                                                     {"picked-cell", &OverlayChoice::picked_cell}}};
constexpr int kLargestSize = 10000;
constexpr int kFewestPixels = 16;  // smallest width and height of a picture
constexpr int kMostPixels = 8192;
std::string size_text(const SceneInfo& scene, int size) {
  SceneOptions options;
  options.size = size;
  options.settings.backend = Backend::cpu;
  return fmt::format("{} {} = {} triangles", size, scene.size_unit, scene.make(options)->count_triangles());
}

void print_scene_list() {
  for (const SceneInfo& scene : scenes()) {
    fmt::print("{}\n  {}\n  default size {}\n", scene.name, scene.description, size_text(scene, scene.default_size));
    if (scene.paper_size != 0) fmt::print("  --size paper {}\n", size_text(scene, scene.paper_size));
    fmt::print("  picture docs/pictures/{}.png\n", scene.name);
  }
}

int size_from(const std::string& word, const SceneInfo& scene) {
  if (word == "paper") {
    if (scene.paper_size == 0) throw CLI::ValidationError("--size", fmt::format("{} is not in the paper", scene.name));
    return scene.paper_size;
  }
  int size = 0;
  if (!CLI::detail::lexical_cast(word, size) || size < scene.smallest_size || size > kLargestSize) {
    throw CLI::ValidationError("--size", fmt::format("'{}' is neither 'paper' nor a number of {} from {} to {}", word,
                                                     scene.size_unit, scene.smallest_size, kLargestSize));
  }
  return size;
}

/// Returns the number of letters to insert, remove or replace to get from one word to the other (Levenshtein 1966).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, replaced}));
    }
  }
  return row.back();
}

/// Returns the name of the scene that is most like the word; empty where none is similar.
std::string suggestion_for(const std::string& word) {
  const auto distance = [&](const SceneInfo& scene) { return edit_distance(word, scene.name); };
  const auto nearest = std::min_element(scenes().begin(), scenes().end(), [&](const SceneInfo& a, const SceneInfo& b) {
    return distance(a) < distance(b);
  });
  return distance(*nearest) <= word.size() / 2 ? fmt::format("; is '{}' meant?", nearest->name) : "";
}

void check_scene(DemoCommand& command, const std::string& size) {
  const SceneInfo* scene = find_scene(command.scene);
  if (scene == nullptr) {
    throw CLI::ValidationError(
        "SCENE", fmt::format("there is no scene '{}'{}; see --list", command.scene, suggestion_for(command.scene)));
  }
  if (!size.empty()) command.options.size = size_from(size, *scene);
}

void take_picture_size(const std::string& word, PictureOptions& pictures) {
  const std::size_t cross = word.find('x');
  const auto take = [&](const std::string& digits, int& pixels) {
    return CLI::detail::lexical_cast(digits, pixels) && pixels >= kFewestPixels && pixels <= kMostPixels;
  };
  if (cross == std::string::npos || !take(word.substr(0, cross), pictures.width) ||
      !take(word.substr(cross + 1), pictures.height)) {
    throw CLI::ValidationError("--picture-size", fmt::format("'{}' is not WIDTHxHEIGHT with numbers from {} to {}",
                                                             word, kFewestPixels, kMostPixels));
  }
}

void take_overlays(const std::vector<bool OverlayChoice::*>& overlays, DemoCommand& command) {
  for (bool OverlayChoice::*overlay : overlays) command.pictures.overlays.*overlay = true;
  const OverlayChoice& chosen = command.pictures.overlays;
  if (!command.view && (chosen.cells || chosen.children || chosen.picked_cell)) {
    throw CLI::ValidationError("--overlays", "cells, children and picked-cell need --view");
  }
}

void check_exported_step(const CLI::App& app, const DemoCommand& command) {
  if (app.count("--export-step") == 0) return;
  const auto& [step, folder] = command.exported_step;
  if (step < 1 || step > command.steps) {
    throw CLI::ValidationError("--export-step", fmt::format("{} is not a step from 1 to {}", step, command.steps));
  }
  if (folder.empty()) throw CLI::ValidationError("--export-step", "DIR is empty");
}

void check_mesh_files(const std::string& target) {
  if (target.find('#') == std::string::npos) return;  // a folder
  const std::string extension = std::filesystem::path(target).extension().string();
  if (std::find(mesh_tools::kWrittenExtensions.begin(), mesh_tools::kWrittenExtensions.end(), extension) ==
      mesh_tools::kWrittenExtensions.end()) {
    throw CLI::ValidationError(
        "--export", fmt::format("'{}' ends in none of {}", target, fmt::join(mesh_tools::kWrittenExtensions, ", ")));
  }
}

}  // namespace

const char* name_of(World world) {
  return name_of(kWorlds, world);
}

ParsedCommandLine parse_command_line(int argc, char** argv) {
  DemoCommand command;
  SceneOptions& options = command.options;
  options.settings.detection = Detection::ccd;
  options.settings.edge_contacts = bullet::EdgeContacts::respond;
  bool list = false;
  std::string size, size_of_pictures;

  CLI::App app("Simulates a scene of Bullet soft bodies and measures it, one row per second of simulation.",
               "softcd-demo");
  app.allow_windows_style_options(false);  // as elsewhere, an argument may begin with a slash
  app.add_option("scene", command.scene, "See --list")->option_text("SCENE [cloth-on-ball]");
  app.add_flag("--list", list, "Describe the scenes");
  add_choice(app, "--world", kWorlds, options.world,
             "Bullet's classic soft world, or its deformable world, which integrates springs explicitly,\n"
             "in steps of 1/240 second");
  add_choice(app, "--collision", options.collision,
             "The detector of contacts between soft bodies. bullet finds none within a body");
  app.add_option_function<std::string>(
         "--preset",
         [&](const std::string& word) { options.settings = value_of(bullet::kPresets, word, "--preset")(); },
         "softcd's settings, which the options below change. balanced is the library's default.\n"
         "Default: ccd, and edges respond")
      ->option_text(join_names(bullet::kPresets, "|"));
  add_fields<bullet::Settings>(app, options.settings, {"read_out"});
  app.add_option("--iterations", options.iterations,
                 "Iterations of Bullet's classic solver: Config::piterations of all bodies")
      ->option_text("N [the scene's]")
      ->check(CLI::Range(1, 1000));
  app.add_option("--steps", command.steps, "Steps of 1/120 second")
      ->option_text("N [600]")
      ->check(CLI::Range(1L, 1000000L));
  app.add_option("--size", size,
                 "Size in the unit that --list names. paper: about as many triangles as in the paper of Wong,\n"
                 "Leach and Zambetta")
      ->option_text("N|paper");
  app.add_option("--picture", command.picture_file, "PNG file for the final state")
      ->option_text("FILE [softcd-demo.png, where pictures can be drawn]")
      ->take_last();
  app.add_option("--picture-size", size_of_pictures, "Size of --picture and --record, in pixels")
      ->option_text(fmt::format("WIDTHxHEIGHT [{}x{}]", command.pictures.width, command.pictures.height));
  app.add_option("--record", command.record,
                 "Write frames as pictures DIR/frame-0000.png, ..., or as a video (by the program ffmpeg)")
      ->option_text("DIR|FILE.mp4");
  app.add_option("--export", command.mesh_files,
                 "Write all bodies of each frame as one file: DIR/frame-0000.ply, ..., or a name in which a row of\n"
                 "# stands for the frame's number and whose end is .ply, .stl (both binary) or .glb (glTF)")
      ->option_text("DIR|PATTERN");
  app.add_option("--frame-steps", command.frame_steps,
                 "Steps from one frame of --record and --export to the next; 4 are 1/30 second")
      ->option_text("N [4]")
      ->check(CLI::Range(1, 120));
  app.add_option("--export-step", command.exported_step,
                 "Write all bodies at the beginning and the end of step N, counted from 1, as DIR/t0.ply and\n"
                 "DIR/t1.ply: two frames for softcd-detect")
      ->option_text("N DIR");
  std::vector<bool OverlayChoice::*> overlays;
  CLI::Option* view =
      app.add_flag("--view", command.view,
                   "Show the scene in a window instead of measuring it; a panel there explains mouse and keys");
  add_choices(app, "--overlays", kOverlays, overlays,
              "Overlays on the scene, in pictures and, from the start, in --view's window: the triangles' edges and\n"
              "contacts; in the window alone also grid cells, and the picked triangle's children and cell");
  app.add_option("--view-frames", command.view_frames, "Close --view's window after N frames of two steps each")
      ->option_text("N")
      ->check(CLI::Range(1L, 1000000L))
      ->needs(view);
  app.add_option("--screenshot", command.screenshot_file, "PNG file for the last of --view-frames")
      ->option_text("FILE")
      ->needs("--view-frames");
  app.add_option("--json", command.json_file, "Write every figure as JSON")->option_text("FILE");
  app.footer(
      "Columns: simulated seconds; median milliseconds of a step, and of softcd in it; median contacts a step; then,\n"
      "at the end of the second, vertices on the wrong side of a surface or with an edge that intersects a triangle,\n"
      "and such edges, found in exact arithmetic. The last lines say how a step's time is spent.\n"
      "Exit codes: 0 done; 1 the simulation failed or a result could not be written; 2 wrong command line.");
  try {
    app.parse(argc, argv);
    if (!list) check_scene(command, size);
    check_mesh_files(command.mesh_files);
    check_exported_step(app, command);
    if (!size_of_pictures.empty()) take_picture_size(size_of_pictures, command.pictures);
    take_overlays(overlays, command);
  } catch (const CLI::ParseError& error) {
    return {std::nullopt, app.exit(error) == 0 ? 0 : kExitWrongInput};
  }
  if (list) {
    print_scene_list();
    return {std::nullopt, 0};
  }
  return {command, 0};
}

}  // namespace softcd::demo

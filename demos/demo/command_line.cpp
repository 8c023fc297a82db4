#include "command_line.hpp"

#include <fmt/format.h>

#include <array>

#include "command_line/choices.hpp"

namespace softcd::demo {
namespace {

constexpr std::array<Choice<Collision>, 3> kCollisions = {
    {{"softcd", Collision::softcd}, {"bullet", Collision::bullet}, {"off", Collision::off}}};
constexpr std::array<Choice<bullet::EdgeContacts>, 2> kEdgeContacts = {
    {{"off", bullet::EdgeContacts::off}, {"respond", bullet::EdgeContacts::respond}}};
constexpr std::array<Choice<World>, 2> kWorlds = {{{"soft", World::classic}, {"deformable", World::deformable}}};

std::string scene_list() {
  std::string text;
  for (const SceneInfo& scene : scenes()) {
    text += fmt::format("{:<14} {} ({} {})\n", scene.name, scene.description, scene.default_size, scene.size_unit);
  }
  return text;
}

}  // namespace

const char* name_of(Collision collision) {
  return name_of(kCollisions, collision);
}

const char* name_of(World world) {
  return name_of(kWorlds, world);
}

ParsedCommandLine parse_command_line(int argc, char** argv) {
  DemoCommand command;
  SceneOptions& options = command.options;
  options.settings.detection = Detection::ccd;
  options.settings.edge_contacts = bullet::EdgeContacts::respond;
  bool list = false;

  CLI::App app("Simulates a scene of Bullet soft bodies and measures it, one row per second of simulation.",
               "softcd-demo");
  app.add_option("scene", command.scene, "See --list")->option_text("SCENE [cloth-on-ball]");
  app.add_flag("--list", list, "Name the scenes");
  add_choice(app, "--world", kWorlds, options.world,
             "Bullet's classic soft world, or its deformable world, of springs that are integrated\n"
             "explicitly, in steps of 1/240 second");
  add_choice(app, "--collision", kCollisions, options.collision,
             "Who finds contacts between soft bodies. bullet knows none within a body");
  add_choice(app, "--backend", kBackends, options.settings.backend,
             "Where softcd computes; auto takes a GPU when there is one");
  add_choice(app, "--detection", kDetections, options.settings.detection,
             "softcd's. ccd: along the motion of a step; dcd: distances at its end, Bullet's rule");
  add_choice(app, "--edges", kEdgeContacts, options.settings.edge_contacts,
             "Whether softcd also looks for contacts between edges, and Bullet answers them");
  app.add_option("--steps", command.steps, "Steps of 1/120 second")
      ->option_text("N [600]")
      ->check(CLI::Range(1L, 1000000L));
  app.add_option("--size", options.size, "Size, in the unit that --list names with the default")
      ->option_text("N")
      ->check(CLI::Range(1, 100000));
  app.add_option("--picture", command.picture_file, "PNG file for the final state")
      ->option_text("FILE [softcd-demo.png]")
      ->take_last();
  app.add_option("--record", command.record_folder, "Write every fourth step as DIR/frame-0000.png, ... (30 a second)")
      ->option_text("DIR");
  app.add_option("--json", command.json_file, "Write every figure as JSON")->option_text("FILE");
  app.footer(
      "Columns: simulated seconds; median milliseconds of a step and of softcd's detection in it; median contacts\n"
      "a step; penetrating vertices at the end of the second: those on the wrong side of a surface, and those with\n"
      "an edge that pierces a triangle.\n"
      "Exit codes: 0 done; 1 the simulation failed or a result could not be written; 2 wrong command line.");
  try {
    app.parse(argc, argv);
    if (!list && find_scene(command.scene) == nullptr) {
      throw CLI::ValidationError("SCENE", fmt::format("there is no scene '{}'; see --list", command.scene));
    }
  } catch (const CLI::ParseError& error) {
    return {std::nullopt, app.exit(error) == 0 ? 0 : kExitWrongInput};
  }
  if (list) {
    fmt::print("{}", scene_list());
    return {std::nullopt, 0};
  }
  return {command, 0};
}

}  // namespace softcd::demo

#pragma once

#include <optional>
#include <string>

#include "scenes/scene.hpp"

namespace softcd::demo {

constexpr int kExitFailed = 1;
constexpr int kExitWrongInput = 2;

struct DemoCommand {
  std::string scene = "cloth-on-ball";
  SceneOptions options;
  long steps = 600;
  std::string picture_file = "softcd-demo.png";
  std::string record_folder;  ///< empty: no frames
  std::string json_file;      ///< empty: none
};

/// The command, or the exit code after help, a list or an error has been printed.
struct ParsedCommandLine {
  std::optional<DemoCommand> command;
  int exit_code = 0;
};

ParsedCommandLine parse_command_line(int argc, char** argv);

const char* name_of(Collision collision);
const char* name_of(World world);

}  // namespace softcd::demo

#pragma once

#include <optional>
#include <string>
#include <utility>

#include "scenes/scene.hpp"
#include "viewer/picture_taker.hpp"

namespace softcd::demo {

constexpr int kExitFailed = 1;
constexpr int kExitWrongInput = 2;

constexpr const char* kDefaultPicture = "softcd-demo.png";

struct DemoCommand {
  std::string scene = "cloth-on-ball";
  SceneOptions options;
  long steps = 600;
  std::string picture_file;  ///< empty: kDefaultPicture, if pictures can be drawn
  std::string record;        ///< pictures or a video, see FrameWriter; empty: none
  std::string mesh_files;    ///< see FrameWriter; empty: none
  int frame_steps = 4;       ///< steps from one frame to the next
  /// The step, counted from 1, whose beginning and end are written, and the folder for them; 0: none.
  std::pair<long, std::string> exported_step;
  std::string json_file;        ///< empty: none
  bool view = false;            ///< in a window, instead of measuring
  long view_frames = 0;         ///< 0: until the window is closed
  PictureOptions pictures;      ///< the overlays are those of the window, too
  std::string screenshot_file;  ///< empty: none
};

/// The command, or the exit code after help, a list or an error has been printed.
struct ParsedCommandLine {
  std::optional<DemoCommand> command;
  int exit_code = 0;
};

ParsedCommandLine parse_command_line(int argc, char** argv);

const char* name_of(World world);

}  // namespace softcd::demo

#pragma once

#include <optional>
#include <string>

#include "command_line/option_flags.hpp"
#include "softcd/softcd.hpp"

namespace softcd::demo {

/// The intersections that the program finds in place of contacts.
enum class Intersections : std::uint32_t {
  off,
  regions,  ///< where the last frame intersects itself
};

struct DetectCommand {
  std::string first_frame;
  std::string second_frame;  ///< empty: there is one frame
  PipelineOptions options;
  BodySettings settings;
  Intersections intersections = Intersections::off;
  std::string coloured_file;      ///< the regions' mesh; empty: not written
  std::string contacts_file;      ///< empty: not written
  std::string json_file;          ///< empty: not written
  std::uint32_t repetitions = 0;  ///< 0: one run without warm-up
};

/// Calls visit(field, options) for each option of the library that has a flag: those that concern one body, contacts on
/// the host, and the frames that are given.
template <class Command, class Visit>
void for_each_option(Command& command, const Visit& visit) {
  const auto visit_options = [&](auto field) { visit(field, command.options); };
  for_each_flag<SceneOptions>({}, visit_options);
  for_each_flag<QueryOptions>(
      {"motion_margin", "step_end", "margins", "neighbour_filters", "reuse_pairs", "contacts_on_device"},
      visit_options);
  for_each_flag<BodySettings>({"filter_group", "filter_mask", "self_collision", "kinematic", "vertex_triangle",
                               "edge_edge", "batch", "rest_distance"},
                              [&](auto field) { visit(field, command.settings); });
}

/// The command to carry out, or the exit code when there is none: --help was given or an argument is wrong. The text
/// has then been printed.
struct ParsedCommandLine {
  std::optional<DetectCommand> command;
  int exit_code = 0;
};

ParsedCommandLine parse_command_line(int argc, char** argv);

constexpr int kExitFailure = 1;     ///< the detection or writing its results failed
constexpr int kExitWrongInput = 2;  ///< the command line or a mesh cannot be used

}  // namespace softcd::demo

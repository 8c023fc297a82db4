#include "command_line.hpp"

#include <fmt/format.h>

#include <string>

namespace softcd::demo {
namespace {

/// Adds an option for a file name, which must not be empty: inside the program empty means none.
CLI::Option* add_file(CLI::App& app, const std::string& name, std::string& file, const std::string& description) {
  const auto problem = [](const std::string& word) { return std::string(word.empty() ? "is empty" : ""); };
  return app.add_option(name, file, description)->option_text("FILE")->check(problem);
}

void add_frames(CLI::App& app, DetectCommand& command) {
  add_file(app, "t0", command.first_frame,
           "The mesh at the start of the step, PLY, OBJ or GLB. Alone, with --detection dcd: the\n"
           "only frame")
      ->required();
  add_file(app, "t1", command.second_frame, "The same triangles at the end of the step");
}

void add_detection_options(CLI::App& app, DetectCommand& command) {
  for_each_option(command, [&](auto field, auto& options) { add_field(app, field, options); });
}

void add_output_options(CLI::App& app, DetectCommand& command) {
  add_file(app, "--contacts", command.contacts_file,
           "Write the contacts as CSV with the columns kind,a0,a1,b0,b1,b2,toi,distance: a vertex\n"
           "and a triangle are vt,v,,f0,f1,f2, two edges are ee,e0,e1,g0,g1,. Vertices count from\n"
           "0; toi is the fraction of the step, distance in the positions' unit");
  add_choice(app, "--intersections", command.intersections,
             "regions: in place of contacts, find where the last frame intersects itself: curves, the regions\n"
             "on the wrong side, and how far their vertices have to move to come out");
  add_file(app, "--coloured", command.coloured_file,
           "With --intersections regions: write the last frame as PLY, with the regions in colours by their\n"
           "kind: closed red, loop_with_border orange, open blue, degenerate violet");
  add_file(app, "--json", command.json_file, "Write every figure as JSON; times in milliseconds, memory in bytes");
  app.add_option("--repeat", command.repetitions,
                 "Detect N times after one warm-up and report median times. Default: one run without\n"
                 "warm-up")
      ->option_text("N")
      ->check(CLI::Range(1, 1000000));
}

}  // namespace

ParsedCommandLine parse_command_line(int argc, char** argv) {
  DetectCommand command;
  command.options.detection = Detection::ccd;
  command.options.reuse_pairs = false;  // every repetition is a detection of its own

  CLI::App app("Finds the contacts of a deforming triangle mesh with itself, between two frames or in one.",
               "softcd-detect");
  app.allow_windows_style_options(false);  // as elsewhere, an argument may begin with a slash
  app.footer(
      "PLY: ascii or binary, any number types. Polygons become triangle fans. Triangles with a vertex that is\n"
      "not finite are left out, with a warning.\n"
      "Exit codes: 0 done, with contacts or without; 1 the detection failed or a result could not be\n"
      "written; 2 the command line or a mesh cannot be used.");
  add_frames(app, command);
  add_detection_options(app, command);
  add_output_options(app, command);
  try {
    app.parse(argc, argv);
    const bool finds_contacts = command.intersections == Intersections::off;
    if (finds_contacts && !command.coloured_file.empty()) {
      throw CLI::ValidationError("--coloured", "needs --intersections regions");
    }
    if (!finds_contacts && (!command.contacts_file.empty() || command.repetitions > 0)) {
      throw CLI::ValidationError("--intersections",
                                 "regions are found in place of contacts, once; leave out --contacts and --repeat");
    }
    if (!command.coloured_file.empty() && !command.coloured_file.ends_with(".ply")) {
      throw CLI::ValidationError("--coloured", "only PLY files have colours; the name must end with .ply");
    }
    if (finds_contacts && command.second_frame.empty() && command.options.detection == Detection::ccd) {
      throw CLI::ValidationError("t1", "continuous detection needs two frames; give both, or --detection dcd");
    }
  } catch (const CLI::ParseError& error) {
    return {std::nullopt, app.exit(error) == 0 ? 0 : kExitWrongInput};
  }
  return {command, 0};
}

}  // namespace softcd::demo

#include "command_line.hpp"

#include <fmt/format.h>

#include <array>
#include <string_view>

#include "command_line/choices.hpp"

namespace softcd::demo {
namespace {

void choose_features(std::string_view words, Features& features) {
  features = {false, false};
  while (true) {
    const std::size_t comma = words.find(',');
    const std::string_view word = words.substr(0, comma);
    if (word != "vt" && word != "ee") {
      throw CLI::ValidationError("--features", fmt::format("'{}' is not one of vt, ee", word));
    }
    (word == "vt" ? features.vertex_triangle : features.edge_edge) = true;
    if (comma == std::string_view::npos) return;
    words.remove_prefix(comma + 1);
  }
}

constexpr std::array<Choice<Search>, 2> kIntersections = {{{"off", Search::contacts}, {"regions", Search::regions}}};

std::string refuse_sign(std::string& number) {
  return number.starts_with('-') ? "must not be negative" : "";
}

/// Adds an option for a file name, which must not be empty: inside the program empty means none.
CLI::Option* add_file(CLI::App& app, const std::string& name, std::string& file, const std::string& description) {
  const auto problem = [](const std::string& word) { return std::string(word.empty() ? "is empty" : ""); };
  return app.add_option(name, file, description)->option_text("FILE")->check(problem);
}

void add_frames(CLI::App& app, DetectCommand& command) {
  add_file(app, "t0", command.first_frame,
           "The mesh at the start of the step, PLY, OBJ or GLB. Alone, with --detection dcd: the one\n"
           "frame to look at")
      ->required();
  add_file(app, "t1", command.second_frame, "The same triangles at the end of the step");
}

void add_detection_options(CLI::App& app, DetectCommand& command) {
  PipelineOptions& options = command.options;
  add_choice(app, "--backend", kBackends, options.backend, "The backend; auto takes a GPU where one exists");
  add_choice(app, "--detection", kDetections, options.detection,
             "ccd: along straight lines from t0 to t1; dcd: distances at the last frame given");
  app.add_option_function<std::string>(
         "--features", [&command](const std::string& words) { choose_features(words, command.settings.features); },
         "Kinds of contacts: vertex-triangle, edge-edge")
      ->option_text("vt,ee [vt,ee]");
  add_choice(app, "--accuracy", kAccuracies, options.accuracy,
             "The narrow phase's arithmetic: float32, float64, or float64 that finds everything within a\n"
             "margin. auto: the last for meshes in double, and for ccd with a margin; else float64");
  app.add_option("--margin", command.settings.margin,
                 "The surface's margin, in the positions' unit. Two features are in contact when their\n"
                 "distance is at most the sum of both sides' margins: twice this, in one mesh")
      ->option_text("M [0]");
  app.add_option("--cell-size-factor", options.cell_size_factor,
                 "Cell size of broad phase exact: this times the mean bounding radius of the triangles, on the\n"
                 "CPU of patches of up to 8 triangles. 0 chooses")
      ->option_text("L [0]");
  add_choice(app, "--subdivision", kOnOff, options.subdivision,
             "Virtual subdivision of triangles that are larger than a cell");
  add_choice(app, "--broad-phase", kBroadPhases, options.broad_phase,
             "How candidate pairs are found: uniform has one grid for the largest triangle, and many more tests");
  app.add_option("--memory-limit", options.memory_limit,
                 "The most bytes that the detection may use, also with K, M, G (1000) or KiB, MiB, GiB\n"
                 "(1024); 0 for no limit. Less memory takes more time; too little is an error")
      ->option_text("BYTES [0]")
      ->transform(CLI::AsSizeValue(/*kb_is_1000=*/true))
      ->transform(CLI::Validator(refuse_sign, ""));  // before the units, which read -1 as 2^64 - 1
}

void add_output_options(CLI::App& app, DetectCommand& command) {
  add_file(app, "--contacts", command.contacts_file,
           "Write the contacts as CSV with the columns kind,a0,a1,b0,b1,b2,toi,distance: a vertex\n"
           "and a triangle are vt,v,,f0,f1,f2, two edges are ee,e0,e1,g0,g1,. Vertices count from\n"
           "0; toi is the fraction of the step, distance in the positions' unit");
  add_choice(app, "--intersections", kIntersections, command.search,
             "regions: in place of contacts, find where the last frame is through itself: curves, the regions\n"
             "on the wrong side, and how far their vertices are from the way out");
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
    const bool finds_contacts = command.search == Search::contacts;
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

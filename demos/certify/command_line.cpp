#include "command_line.hpp"

#include <cmath>

#include "command_line/option_flags.hpp"

namespace softcd::demo {
namespace {

std::string refuse_empty(const std::string& word) {
  return word.empty() ? "is empty" : "";
}

void add_meshes(CLI::App& app, CertifyCommand& command) {
  app.add_option("frames", command.frames,
                 "At least two meshes with the same triangles, PLY, OBJ or GLB, in order. A folder stands\n"
                 "for all of its meshes, frame9 before frame10")
      ->option_text("FRAME...")
      ->required()
      ->check(refuse_empty);
  app.add_option("--against", command.against,
                 "A further mesh that the frames are compared with: a file if it stands still, or a folder\n"
                 "with as many meshes as there are frames. May be given several times")
      ->option_text("FILE|DIR")
      ->allow_extra_args(false)
      ->check(refuse_empty);
}

}  // namespace

ParsedCertifyCommand parse_certify_command(int argc, char** argv) {
  CertifyCommand command;
  CLI::App app(
      "Proves that a deforming triangle mesh never crosses itself from frame to frame, along straight\n"
      "paths, or lists the features that touch and when. Also compares the triangles of every frame in\n"
      "exact arithmetic.",
      "softcd-certify");
  app.allow_windows_style_options(false);  // as elsewhere, an argument may begin with a slash
  app.footer(
      "Verdicts of a step: proved; crossed: exact arithmetic shows that features passed through each other;\n"
      "not proved: features touched, or came within rounding of it.\n"
      "Exit codes: 0 proved; 1 not proved, or the run failed; 2 the command line, a mesh or a certificate\n"
      "cannot be used.");
  add_meshes(app, command);
  CLI::Option* const margin =
      app.add_option("--margin", command.options.margin,
                     "Each surface's margin, in the positions' unit. Proves that features stay more than twice\n"
                     "this apart")
          ->option_text("M [0]");
  CLI::Option* const every = app.add_option("--every", command.options.every, "Use the first of every N frames")
                                 ->option_text("N [1]")
                                 ->check(CLI::Range(1, 1000000000));
  CLI::Option* const list = app.add_option("--list", command.options.list, "The most pairs to list for a step or frame")
                                ->option_text("N [100]")
                                ->check(CLI::Range(0, 1000000000));
  add_fields<SceneOptions>(app, command.scene);  // no option changes the certificate
  CLI::Option* const json =
      app.add_option("--json", command.json_file, "Write the certificate")->option_text("FILE")->check(refuse_empty);
  app.add_option("--check", command.check_file,
                 "Repeat a certificate with its options, and compare the bytes. Give the same meshes")
      ->option_text("FILE")
      ->check(refuse_empty)
      ->excludes(margin, every, list, json);
  try {
    app.parse(argc, argv);
    // The detection needs a float that is not below it.
    if (!(command.options.margin >= 0 && command.options.margin <= 1e37)) {
      throw CLI::ValidationError("--margin", "must be from 0 to 1e37");
    }
  } catch (const CLI::ParseError& error) {
    return {std::nullopt, app.exit(error) == 0 ? 0 : kExitUnusableArguments};
  }
  return {command, 0};
}

}  // namespace softcd::demo

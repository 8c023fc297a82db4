#pragma once

#include <optional>
#include <string>
#include <vector>

#include "certificate.hpp"
#include "softcd/softcd.hpp"

namespace softcd::demo {

struct CertifyCommand {
  std::vector<std::string> frames;   ///< files and folders
  std::vector<std::string> against;  ///< a file or a folder for each further mesh
  CertifyOptions options;
  SceneOptions scene;
  std::string json_file;   ///< empty: not written
  std::string check_file;  ///< empty: no certificate to repeat
};

/// The command to carry out, or the exit code when there is none: --help was given or an argument is wrong. The text
/// has then been printed.
struct ParsedCertifyCommand {
  std::optional<CertifyCommand> command;
  int exit_code = 0;
};

ParsedCertifyCommand parse_certify_command(int argc, char** argv);

constexpr int kExitNotProved = 1;          ///< not proved, or the run failed
constexpr int kExitUnusableArguments = 2;  ///< the command line, a mesh or a certificate cannot be used

}  // namespace softcd::demo

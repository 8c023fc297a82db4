#include "program.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "certifier.hpp"
#include "command_line.hpp"
#include "command_line/progress_line.hpp"
#include "command_line/standard_output.hpp"

namespace softcd::demo {
namespace {

namespace fs = std::filesystem;

void warn(std::string_view text) {
  fmt::print(stderr, "softcd-certify: warning: {}\n", text);
}

/// Returns whether a file comes before another one of its folder, by the numbers in their names.
bool comes_before(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return a.parent_path() == b.parent_path() && fs::is_regular_file(a, ignored) &&
         is_before(a.filename().string(), b.filename().string());
}

/// Returns the files that the words stand for. Warns where numbers in names descend, as a shell sorts frame10 before
/// frame9.
std::vector<fs::path> frames_of(const std::vector<std::string>& words) {
  std::vector<fs::path> files;
  for (const std::string& word : words) {
    for (fs::path& file : files_of(word)) files.push_back(std::move(file));
  }
  for (std::size_t i = 1; i < files.size(); ++i) {
    if (!comes_before(files[i], files[i - 1])) continue;
    warn(fmt::format("{} comes before {}: give the folder to sort frames by number", files[i - 1].string(),
                     files[i].string()));
    break;
  }
  return files;
}

std::vector<fs::path> every_of(const std::vector<fs::path>& files, std::size_t every) {
  std::vector<fs::path> chosen;
  for (std::size_t i = 0; i < files.size(); i += every) chosen.push_back(files[i]);
  return chosen;
}

std::vector<MeshSequence> sequences_of(const CertifyCommand& command) {
  const std::vector<fs::path> frames = frames_of(command.frames);
  const std::size_t every = command.options.every;
  std::vector<MeshSequence> meshes = {MeshSequence(every_of(frames, every))};
  if (meshes[0].size() < 2) {
    throw mesh_tools::MeshError(
        fmt::format("{}: is the only frame; give at least two, or a smaller --every", frames[0].string()));
  }
  for (const std::string& word : command.against) {
    const std::vector<fs::path> files = files_of(word);
    if (files.size() > 1 && files.size() != frames.size()) {
      throw mesh_tools::MeshError(
          fmt::format("{}: has {} meshes, but there are {} frames; give as many, or one for a mesh that stands still",
                      word, files.size(), frames.size()));
    }
    meshes.emplace_back(every_of(files, every));
  }
  return meshes;
}

/// Throws MeshError where the certificate is of other numbers of files.
void require_same_files(const WrittenCertificate& written, const std::vector<MeshSequence>& meshes) {
  const auto require = [&](std::size_t given, std::size_t certified, const char* what) {
    if (given == certified) return;
    throw mesh_tools::MeshError(
        fmt::format("{}: is about {} {}, but {} are given; give the same", written.file, certified, what, given));
  };
  require(meshes.size() - 1, written.frame_counts.size() - 1, "meshes of --against");
  require(meshes[0].size(), written.frame_counts[0], "frames");
  for (std::size_t i = 1; i < meshes.size(); ++i) {
    require(meshes[i].size(), written.frame_counts[i], "files of one mesh of --against");
  }
}

void write_file(const std::string& file, const std::string& content) {
  std::ofstream stream(file, std::ios::binary);
  stream << content;
  stream.close();
  if (!stream) throw std::runtime_error(fmt::format("{}: cannot be written (does its folder exist?)", file));
}

int run(CertifyCommand command) {
  std::optional<WrittenCertificate> written;
  if (!command.check_file.empty()) {
    written = read_certificate(command.check_file);
    command.options = written->options;
  }
  std::vector<MeshSequence> meshes = sequences_of(command);
  if (written) require_same_files(*written, meshes);

  ProgressLine progress;
  std::set<std::string, std::less<>> warned;
  const auto log = [&](LogLevel level, std::string_view text) {
    if (level != LogLevel::warning || !warned.emplace(text).second) return;
    progress.clear();
    warn(text);
  };
  const Certificate certificate = certify(
      command.options, command.scene, std::move(meshes), [&](const std::string& text) { progress.show(text); }, log);
  progress.clear();

  const std::string text = text_of(certificate);
  if (!command.json_file.empty()) write_file(command.json_file, text);
  print_summary(certificate);
  if (written) {
    const std::string problem = difference(*written, text);
    if (!problem.empty()) {
      throw std::runtime_error(fmt::format("{}: is not reproduced: {}", command.check_file, problem));
    }
    fmt::print("{}: repeated, byte for byte\n", command.check_file);
  }
  if (certificate.is_proved()) return 0;
  fmt::print(stderr, "softcd-certify: not proved; --json FILE writes the pairs that touch or may touch\n");
  return kExitNotProved;
}

int fail(int exit_code, const std::exception& error) {
  fmt::print(stderr, "softcd-certify: {}\n", error.what());
  return exit_code;
}

}  // namespace

int certify_program(int argc, char** argv) {
  try {
    const ParsedCertifyCommand parsed = parse_certify_command(argc, argv);
    const int exit_code = parsed.command ? run(*parsed.command) : parsed.exit_code;
    finish_standard_output();
    return exit_code;
  } catch (const mesh_tools::MeshError& error) {
    return fail(kExitUnusableArguments, error);
  } catch (const InvalidInput& error) {
    return fail(kExitUnusableArguments, error);
  } catch (const std::exception& error) {
    return fail(kExitNotProved, error);
  }
}

}  // namespace softcd::demo

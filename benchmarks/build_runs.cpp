#include "build_runs.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace softcd::benchmarks {
namespace {

namespace fs = std::filesystem;

/// A file name in a temporary folder that is removed with this object.
class TemporaryFile {
 public:
  TemporaryFile() {
    std::string name = (fs::temp_directory_path() / "softcd-bench-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made");
    folder_ = name;
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  std::string name() const { return (folder_ / "results.json").string(); }

 private:
  fs::path folder_;
};

/// Runs a program and returns its exit code. Drops its standard output.
int run_program(std::vector<std::string> command) {
  std::vector<char*> argv(command.size() + 1, nullptr);
  std::transform(command.begin(), command.end(), argv.begin(), [](std::string& word) { return word.data(); });
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error(fmt::format("{}: {}", command[0], std::strerror(error)));
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

Results run_detector(const std::string& build, const std::vector<std::string>& arguments) {
  const TemporaryFile file;
  std::vector<std::string> command = {build, "detector"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  command.insert(command.end(), {"--json", file.name()});
  if (run_program(command) != 0) throw std::runtime_error(fmt::format("this failed: {}", fmt::join(command, " ")));
  return read_results(file.name());
}

}  // namespace

std::pair<Results, Results> run_builds(const std::string& old_build, const std::string& new_build,
                                       const std::vector<std::string>& arguments, int rounds) {
  std::vector<Results> old_runs, new_runs;
  for (int round = 0; round < rounds; ++round) {
    fmt::print(stderr, "softcd-bench: round {} of {}\n", round + 1, rounds);
    old_runs.push_back(run_detector(old_build, arguments));
    new_runs.push_back(run_detector(new_build, arguments));
  }
  return {merge(old_runs), merge(new_runs)};
}

}  // namespace softcd::benchmarks

// Runs the programs with random command lines: existing options with allowed values, with others, and with bytes.
// SOFTCD_COMMAND_LINES is their number for each program, SOFTCD_COMMAND_LINES_RUN the first of them.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "random.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

using Words = std::vector<std::string>;

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

struct Ending {
  bool is_regular = false;  ///< no signal, and within the time that it has
  int exit_code = -1;
  std::string errors;
  std::string output;
};

std::uint64_t number(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::stoull(text) : otherwise;
}

/// Becomes the program, in the folder, without a display, for at most half a minute.
[[noreturn]] void become(const std::string& program, const Words& words, const TemporaryFolder& folder) {
  const auto open_as = [](const std::string& file, int flags, int descriptor) {
    dup2(open(file.c_str(), flags, 0600), descriptor);
  };
  open_as("/dev/null", O_RDONLY, STDIN_FILENO);
  open_as(folder.file("output"), O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
  open_as(folder.file("errors"), O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO);
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  alarm(60);
  const rlimit no_cores{0, 0};
  setrlimit(RLIMIT_CORE, &no_cores);
  std::vector<char*> arguments = {const_cast<char*>(program.c_str())};
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  if (chdir(folder.file("").c_str()) == 0) execv(program.c_str(), arguments.data());
  _exit(99);
}

Ending run(const std::string& program, const Words& words, const TemporaryFolder& folder) {
  const pid_t child = fork();
  if (child == 0) become(program, words, folder);
  int status = 0;
  waitpid(child, &status, 0);
  return {WIFEXITED(status), WIFEXITED(status) ? WEXITSTATUS(status) : -1, folder.read("errors"),
          folder.read("output")};
}

/// Useful words of a help text: options, and values without numbers, because large numbers take long.
struct Vocabulary {
  Words options, values;

  explicit Vocabulary(const std::string& help) {
    std::set<std::string> options_found;
    std::set<std::string> values_found;
    std::string word;
    for (const char c : help + " ") {
      if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-') {
        word += c;
        continue;
      }
      const bool is_number =
          std::any_of(word.begin(), word.end(), [](unsigned char d) { return std::isdigit(d) != 0; });
      if (word.rfind("--", 0) == 0 && word.size() > 2 && word != "--list") {  // --list makes all scenes to count them
        options_found.insert(word);
      } else if (!word.empty() && !is_number && word != "paper") {
        values_found.insert(word);
      }
      word.clear();
    }
    options.assign(options_found.begin(), options_found.end());
    values.assign(values_found.begin(), values_found.end());
  }
};

class CommandLines : public testing::Test {
 protected:
  CommandLines() {
    folder_.write("mesh.obj", kTriangle);
    folder_.write("empty.ply", "");
    folder_.write("broken.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000\n");
  }

  std::string help_of(const std::string& program, Words subcommand) const {
    subcommand.emplace_back("--help");
    return run(program, subcommand, folder_).output;
  }

  std::string any_of(const Words& words) { return words[random_.below(static_cast<std::uint32_t>(words.size()))]; }

  std::string bytes() {
    std::string text;
    const std::uint32_t length = random_.below(random_.chance(0.05) ? 20000 : 12);
    for (std::uint32_t i = 0; i < length; ++i) {
      const char c = static_cast<char>(1 + random_.below(255));
      text += c == '\n' ? ' ' : c;
    }
    return text;
  }

  std::string value(const Vocabulary& vocabulary) {
    static const Words numbers = {"0",          "1",
                                  "2",          "7",
                                  "-1",         "1.5",
                                  "1e-30",      "1e400",
                                  "nan",        "-inf",
                                  "0x10",       "4294967296",
                                  "2147483648", "18446744073709551616",
                                  "1,2",        "1e9GiB",
                                  "3K",         "-0",
                                  "99999999",   ""};
    static const Words files = {"mesh.obj",           "mesh.obj", "mesh.obj",  "empty.ply", "broken.ply",
                                "no-such-file.obj",   "/",        "/dev/null", "/dev/full", "written",
                                "no-such-folder/file"};
    switch (random_.below(4)) {
      case 0:
        return any_of(numbers);
      case 1:
        return any_of(files);
      case 2:
        return any_of(vocabulary.values);
      default:
        return random_.chance(0.2) ? bytes() : any_of(vocabulary.values);
    }
  }

  Words line(const Vocabulary& vocabulary) {
    Words words;
    const std::uint32_t count = random_.below(6);
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::string option = any_of(vocabulary.options);
      if (random_.chance(0.2)) {
        words.push_back(option + "=" + value(vocabulary));
        continue;
      }
      if (random_.chance(0.85)) words.push_back(option);
      if (random_.chance(0.85)) words.push_back(value(vocabulary));
      if (random_.chance(0.02)) words.emplace_back("--");
    }
    return words;
  }

  /// Expects exit code 0, or 1 or 2 with a sentence.
  void expect_answer(const std::string& program, const Words& words) {
    const Ending ending = run(program, words, folder_);
    const auto lines = std::count(ending.errors.begin(), ending.errors.end(), '\n');
    const bool has_sentence = !ending.errors.empty() && lines <= 4 &&
                              ending.errors.find("terminate called") == std::string::npos &&
                              ending.errors.find("std::") == std::string::npos;
    const bool is_answered =
        ending.exit_code == 0 || ((ending.exit_code == 1 || ending.exit_code == 2) && has_sentence);
    EXPECT_TRUE(ending.is_regular && is_answered)
        << testing::PrintToString(words) << "\nends with " << ending.exit_code << ": " << ending.errors;
  }

  /// Runs many command lines. Each begins with the words `first`.
  void expect_answers(const std::string& program, const Words& subcommand, const Words& first) {
    const Vocabulary vocabulary(help_of(program, subcommand));
    ASSERT_GT(vocabulary.options.size(), 1U);
    for (std::uint64_t i = 0; i < lines_ && !HasFailure(); ++i) {
      Words words = subcommand;
      words.insert(words.end(), first.begin(), first.end());
      for (const std::string& word : line(vocabulary)) words.push_back(word);
      expect_answer(program, words);
    }
  }

  std::uint64_t lines_ = number("SOFTCD_COMMAND_LINES", 40);

 private:
  TemporaryFolder folder_;
  Random random_{number("SOFTCD_COMMAND_LINES_RUN", 1)};
};

TEST_F(CommandLines, of_softcd_detect_are_answered) {
  expect_answers(SOFTCD_DETECT, {}, {"mesh.obj"});
  expect_answers(SOFTCD_DETECT, {}, {});
}

#ifdef SOFTCD_CERTIFY
TEST_F(CommandLines, of_softcd_certify_are_answered) {
  expect_answers(SOFTCD_CERTIFY, {}, {"mesh.obj", "mesh.obj"});
  expect_answers(SOFTCD_CERTIFY, {}, {});
}
#endif

#ifdef SOFTCD_DEMO
TEST_F(CommandLines, of_softcd_demo_are_answered) {
  expect_answers(SOFTCD_DEMO, {}, {"--steps", "1", "--size", "8"});
}
#endif

#ifdef SOFTCD_BENCH
/// Returns the subcommands that the help text lists, each on a line of its own.
Words subcommands_of(const std::string& help) {
  Words found = {""};
  std::istringstream lines(help.substr(std::min(help.size(), help.find("Subcommands:"))));
  for (std::string text; std::getline(lines, text);) {
    if (text.size() < 3 || text.rfind("  ", 0) != 0 || text[2] == ' ') continue;
    found.push_back(text.substr(2, text.find(' ', 2) - 2));
  }
  return found;
}

// No line is valid, so nothing is measured.
TEST_F(CommandLines, of_softcd_bench_are_answered) {
  const Words subcommands = subcommands_of(help_of(SOFTCD_BENCH, {}));
  ASSERT_GT(subcommands.size(), 4U);
  lines_ = std::max<std::uint64_t>(lines_ / subcommands.size(), 1);
  for (const std::string& subcommand : subcommands) {
    SCOPED_TRACE(subcommand);
    expect_answers(SOFTCD_BENCH, subcommand.empty() ? Words() : Words{subcommand}, {"--no-such-option"});
  }
}
#endif

}  // namespace
}  // namespace softcd::test

#pragma once

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "temporary_folder.hpp"

namespace softcd::test {

struct Result {
  int exit_code;
  std::string output;
  std::string errors;
};

/// Runs a command; its output goes through two files in `folder`.
inline Result run_shell(const std::string& command, const TemporaryFolder& folder) {
  const std::string redirected = command + " >'" + folder.file("output") + "' 2>'" + folder.file("errors") + "'";
  const int status = std::system(redirected.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, folder.read("output"), folder.read("errors")};
}

/// Runs a program. `arguments` are as a shell reads them.
inline Result run_program(const std::string& program, const std::string& arguments, const TemporaryFolder& folder) {
  return run_shell("'" + program + "' " + arguments, folder);
}

/// Expects refusal: exit code 2 and one sentence on standard error, nothing else.
inline void expect_refused(const std::string& program, const std::string& arguments, const TemporaryFolder& folder,
                           const std::string& problem) {
  const Result result = run_program(program, arguments, folder);
  EXPECT_EQ(result.exit_code, 2) << arguments;
  EXPECT_THAT(result.errors, testing::HasSubstr(problem));
  EXPECT_THAT(result.output, testing::IsEmpty());
}

}  // namespace softcd::test

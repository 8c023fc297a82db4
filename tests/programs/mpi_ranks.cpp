#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <sstream>
#include <string>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

struct Step {
  int ranks = 0;
  std::size_t found = 0;   ///< by all ranks together
  std::size_t of_all = 0;  ///< as each rank received them
};

/// Parses the ranks' output.
std::map<int, Step> steps_of(const std::string& output) {
  std::map<int, Step> steps;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    int number = 0;
    int rank = 0;
    std::size_t found = 0;
    std::size_t of_all = 0;
    if (std::sscanf(line.c_str(), "step %d: rank %d has found %zu of %zu contacts", &number, &rank, &found, &of_all) !=
        4) {
      continue;
    }
    Step& step = steps[number];
    if (step.ranks > 0) {
      EXPECT_EQ(of_all, step.of_all) << line;
    }
    ++step.ranks;
    step.found += found;
    step.of_all = of_all;
  }
  return steps;
}

TEST(MpiRanks, find_each_contact_once) {
  const TemporaryFolder folder;
  for (const int processes : {2, 3}) {
    // Settings of Open MPI, which otherwise refuses to start as root and to start more processes than cores.
    const Result result = run_shell(
        "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 "
        "'" SOFTCD_MPI_START "' " SOFTCD_MPI_PROCESSES " " +
            std::to_string(processes) + " '" SOFTCD_APP_RANKS "'",
        folder);
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    const std::map<int, Step> steps = steps_of(result.output);
    ASSERT_EQ(steps.size(), 3U) << result.output;
    for (const auto& [number, step] : steps) {
      EXPECT_EQ(step.ranks, processes) << result.output;
      EXPECT_EQ(step.found, step.of_all) << result.output;
      EXPECT_GT(step.of_all, 500U) << result.output;
    }
  }
}

}  // namespace
}  // namespace softcd::test

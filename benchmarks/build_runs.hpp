#pragma once

#include <string>
#include <utility>
#include <vector>

#include "results.hpp"

namespace softcd::benchmarks {

/// Runs `detector` with `arguments` of two builds of softcd-bench in turn, `rounds` times each: old, new, old, new ...
/// Drops their output. Throws std::runtime_error when one fails.
std::pair<Results, Results> run_builds(const std::string& old_build, const std::string& new_build,
                                       const std::vector<std::string>& arguments, int rounds);

}  // namespace softcd::benchmarks

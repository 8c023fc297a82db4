#pragma once

#include <string>

#include "softcd/core/statistics.hpp"

namespace softcd::test {

/// Returns the CPU or, if the environment has SOFTCD_TEST_BACKEND=cuda, the GPU. Tests ON_EVERY_BACKEND run on both.
Backend backend_under_test();

/// Returns why there is no such backend here; empty where there is.
std::string why_missing(Backend backend);

}  // namespace softcd::test

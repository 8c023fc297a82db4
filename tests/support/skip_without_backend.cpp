#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "backend_under_test.hpp"

namespace softcd::test {
namespace {

/// Skips all tests, and prints the reason, where the backend under test is not available.
class BackendUnderTest : public testing::Environment {
 public:
  void SetUp() override {
    const std::string reason = why_missing(backend_under_test());
    if (reason.empty()) return;
    std::printf("[  SKIPPED ] %s\n", reason.c_str());  // the words that ctest knows
    GTEST_SKIP() << reason;
  }
};

const testing::Environment* const kBackendUnderTest = testing::AddGlobalTestEnvironment(new BackendUnderTest);

}  // namespace
}  // namespace softcd::test

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "backend_under_test.hpp"

namespace softcd::test {
namespace {

/// Where the backend under test cannot be had, no test runs and a sentence says why.
class BackendUnderTest : public testing::Environment {
 public:
  void SetUp() override {
    const std::string reason = why_missing(backend_under_test());
    if (reason.empty()) return;
    std::printf("[  SKIPPED ] %s\n", reason.c_str());  // as ctest knows it
    GTEST_SKIP() << reason;
  }
};

const testing::Environment* const kBackendUnderTest = testing::AddGlobalTestEnvironment(new BackendUnderTest);

}  // namespace
}  // namespace softcd::test

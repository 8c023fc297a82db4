#include <gtest/gtest.h>

#include <cstdio>

#include "backend_under_test.hpp"
#include "softcd/softcd.hpp"

namespace softcd::test {
namespace {

/// Where the backend under test cannot be had, no test runs and a sentence says why.
class BackendUnderTest : public testing::Environment {
 public:
  void SetUp() override {
    PipelineOptions options;
    options.backend = backend_under_test();
    try {
      const CollisionPipeline pipeline(options);
    } catch (const BackendError& error) {
      std::printf("[  SKIPPED ] %s\n", error.what());  // as ctest knows it
      GTEST_SKIP() << error.what();
    }
  }
};

const testing::Environment* const kBackendUnderTest = testing::AddGlobalTestEnvironment(new BackendUnderTest);

}  // namespace
}  // namespace softcd::test

#include "backend_under_test.hpp"

#include <cstdlib>
#include <string_view>

#include "softcd/softcd.hpp"

namespace softcd::test {

Backend backend_under_test() {
  const char* const name = std::getenv("SOFTCD_TEST_BACKEND");
  return name != nullptr && std::string_view(name) == "cuda" ? Backend::cuda : Backend::cpu;
}

std::string why_missing(Backend backend) {
  SceneOptions options;
  options.backend = backend;
  try {
    const softcd::Scene scene(options);
  } catch (const BackendError& error) {
    return error.what();
  }
  return {};
}

}  // namespace softcd::test

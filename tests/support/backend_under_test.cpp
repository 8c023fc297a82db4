#include "backend_under_test.hpp"

#include <cstdlib>
#include <string_view>

namespace softcd::test {

Backend backend_under_test() {
  const char* const name = std::getenv("SOFTCD_TEST_BACKEND");
  return name != nullptr && std::string_view(name) == "cuda" ? Backend::cuda : Backend::cpu;
}

}  // namespace softcd::test

#include "softcd/core/loaded_library.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace softcd::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

#if !defined(__EMSCRIPTEN__)
#if defined(_WIN32)
constexpr const char* kLibrary = "msvcrt.dll";
#else
constexpr const char* kLibrary = "libm.so.6";
#endif

TEST(LoadedLibrary, HasItsFunctions) {
  LoadedLibrary library(kLibrary);
  double (*square_root)(double) = nullptr;
  library.find("sqrt", square_root);
  ASSERT_THAT(library.problem(), IsEmpty());
  EXPECT_EQ(square_root(16.0), 4.0);
}

TEST(LoadedLibrary, SaysWhichFunctionItLacks) {
  LoadedLibrary library(kLibrary);
  double (*none)(double) = std::sqrt;
  library.find("softcd_has_no_such_function", none);
  EXPECT_EQ(none, nullptr);
  EXPECT_THAT(library.problem(), HasSubstr("softcd_has_no_such_function"));
}
#endif

TEST(LoadedLibrary, SaysWhichLibraryIsMissing) {
  LoadedLibrary library("softcd_no_such_library");
  double (*none)(double) = std::sqrt;
  library.find("sqrt", none);
  EXPECT_EQ(none, nullptr);
  EXPECT_THAT(library.problem(), HasSubstr("softcd_no_such_library"));
}

}  // namespace
}  // namespace softcd::test

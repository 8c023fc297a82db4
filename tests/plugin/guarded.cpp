#include "guarded.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <system_error>

namespace softcd::test {
namespace {

using testing::HasSubstr;

template <class Exception, class Throw>
std::string message_of(const Throw& f) {
  try {
    guarded([] { return "out of memory"; }, f);
  } catch (const Exception& error) {
    return error.what();
  }
  return "no exception";
}

TEST(Guarded, memory_that_ran_out_is_an_error_with_its_problem) {
  EXPECT_EQ(message_of<OutOfMemory>([] { throw std::bad_alloc(); }), "out of memory");
  EXPECT_EQ(message_of<OutOfMemory>([] { throw std::bad_array_new_length(); }), "out of memory");
}

TEST(Guarded, threads_that_cannot_be_started_are_an_error_that_says_so) {
  const auto names_threads = testing::AllOf(HasSubstr("pthread_create has failed"), HasSubstr("ulimit -u"));
  EXPECT_THAT(message_of<Error>([] { throw std::runtime_error("pthread_create has failed"); }), names_threads);
  EXPECT_THAT(message_of<Error>([] {
                throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again),
                                        "pthread_create has failed");
              }),
              names_threads);
}

TEST(Guarded, errors_stay_what_they_are) {
  EXPECT_EQ(message_of<InvalidInput>([] { throw InvalidInput("no"); }), "no");
  EXPECT_EQ(message_of<BackendError>([] { throw BackendError("no"); }), "no");
}

TEST(Guarded, what_the_device_says_is_the_backends_error) {
  EXPECT_EQ(message_of<BackendError>([] { throw DeviceError("the device fell off the bus"); }),
            "the device fell off the bus");
}

TEST(Guarded, the_callers_own_exceptions_pass) {
  const auto call_caller = [](const auto& exception) { call_back([&] { throw exception; }); };
  EXPECT_THROW(guarded([] { return ""; }, [&] { call_caller(std::bad_alloc()); }), std::bad_alloc);
  EXPECT_THROW(guarded([] { return ""; }, [&] { call_caller(7); }), int);
}

}  // namespace
}  // namespace softcd::test

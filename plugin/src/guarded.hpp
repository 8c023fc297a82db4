#pragma once

#include <fmt/format.h>

#include <exception>
#include <new>
#include <stdexcept>

#include "softcd/error.hpp"
#include "softcd/pipeline/detector.hpp"

namespace softcd {

/// Carries an exception from the caller's function through guarded().
struct CallbackException {
  std::exception_ptr thrown;
};

/// Calls the caller's function.
template <class Function, class... Arguments>
decltype(auto) call_back(const Function& function, const Arguments&... arguments) {
  try {
    return function(arguments...);
  } catch (...) {
    throw CallbackException{std::current_exception()};
  }
}

namespace detail {

/// Thrown where memory for the text of an error runs out. It is made in advance; a copy shares its text.
// NOLINTNEXTLINE(cert-err58-cpp): without memory for this a program cannot start
inline const OutOfMemory kNoMemoryForText{"memory ran out, even for the text of this error; free memory."};

/// Throws the exception that is being handled as an Error.
template <class MemoryProblem>
[[noreturn]] void rethrow_as_error(const MemoryProblem& memory_problem) {
  try {
    try {
      throw;
    } catch (const DeviceError& error) {
      throw BackendError(error.what());
    } catch (const std::bad_alloc&) {
      throw OutOfMemory(memory_problem());
    } catch (const Error&) {
      throw;
    } catch (const std::exception& error) {
      // oneTBB throws this where it cannot start its threads.
      throw Error(fmt::format(
          "oneTBB failed: {}. Where threads cannot be started, raise the limit on them (ulimit -u).", error.what()));
    }
  } catch (const std::bad_alloc&) {
    throw OutOfMemory(kNoMemoryForText);
  }
}

}  // namespace detail

/// Calls f. Exceptions that leave it are Errors, or come from the caller's functions. `memory_problem()` returns the
/// text for exhausted memory.
template <class MemoryProblem, class F>
decltype(auto) guarded(const MemoryProblem& memory_problem, const F& f) {
  try {
    return f();
  } catch (const CallbackException& exception) {
    std::rethrow_exception(exception.thrown);
  } catch (...) {
    detail::rethrow_as_error(memory_problem);
  }
}

}  // namespace softcd

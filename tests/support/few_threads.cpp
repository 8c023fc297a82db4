#include "few_threads.hpp"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <exception>
#include <iostream>
#include <limits>
#include <memory>

namespace softcd::test {
namespace {

constexpr unsigned kPatience = 60;  ///< seconds

std::atomic<std::size_t> most_threads{std::numeric_limits<std::size_t>::max()};
std::atomic<std::size_t> living{0};
std::atomic<std::size_t> refused{0};

/// The function and argument of a new thread.
struct Routine {
  void* (*run)(void*);
  void* argument;
};

/// Counts the end of a thread, also by pthread_exit.
struct Leaving {
  ~Leaving() { --living; }
};

void* run(void* argument) {
  const std::unique_ptr<Routine> routine(static_cast<Routine*>(argument));
  const Leaving leaving;
  return routine->run(routine->argument);
}

/// Runs f in the child process and writes its result.
[[noreturn]] void write_and_exit(int pipe, const std::function<std::vector<std::byte>()>& f) {
  alarm(kPatience);
  int status = EXIT_FAILURE;
  try {
    const std::vector<std::byte> bytes = f();
    std::size_t written = 0;
    while (written < bytes.size()) {
      const ssize_t count = ::write(pipe, bytes.data() + written, bytes.size() - written);
      if (count <= 0) break;
      written += static_cast<std::size_t>(count);
    }
    if (written == bytes.size()) status = EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
  }
  ::_exit(status);
}

}  // namespace

void limit_threads(std::size_t most) {
  most_threads = most;
}

std::size_t refused_threads() {
  return refused;
}

std::optional<std::vector<std::byte>> with_few_threads(std::size_t most,
                                                       const std::function<std::vector<std::byte>()>& f) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) return std::nullopt;
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    limit_threads(most);
    write_and_exit(ends[1], f);
  }
  ::close(ends[1]);
  std::vector<std::byte> bytes;
  std::array<std::byte, 4096> part;
  ssize_t count = 0;
  while ((count = ::read(ends[0], part.data(), part.size())) > 0) {
    bytes.insert(bytes.end(), part.begin(), part.begin() + count);
  }
  ::close(ends[0]);
  int status = 0;
  if (child < 0 || ::waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return std::nullopt;
  }
  return bytes;
}

}  // namespace softcd::test

// Visible, so that libraries call it, too.
extern "C" __attribute__((visibility("default"))) int pthread_create(pthread_t* thread,
                                                                     const pthread_attr_t* attributes,
                                                                     void* (*routine)(void*), void* argument) {
  namespace test = softcd::test;
  static const auto real = reinterpret_cast<decltype(&pthread_create)>(::dlsym(RTLD_NEXT, "pthread_create"));
  if (++test::living > test::most_threads) {
    --test::living;
    ++test::refused;
    return EAGAIN;
  }
  auto started = std::make_unique<test::Routine>(test::Routine{routine, argument});
  const int status = real(thread, attributes, test::run, started.get());
  if (status == 0) {
    static_cast<void>(started.release());
  } else {
    --test::living;
  }
  return status;
}

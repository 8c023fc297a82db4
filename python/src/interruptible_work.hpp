#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <type_traits>
#include <utility>

/// Long work for Python's main thread, which handles signals. The work has a thread of its own, while the main thread
/// checks for signals. When a handler raises, for example KeyboardInterrupt, the caller continues and the work ends by
/// itself.
namespace softcd::python {

namespace nb = nanobind;

/// Returns whether this thread handles signals.
bool handles_signals();

/// Acquires the interpreter's lock and throws nb::python_error where a signal's handler raises.
void check_signals();

/// The number of pieces of work that run although their caller no longer waits for them.
class AbandonedWork {
 public:
  static void begin();
  static void end();
};

constexpr std::chrono::milliseconds kSignalInterval{50};

template <class F>
class InterruptibleWork {
 public:
  using Result = std::invoke_result_t<F&>;

  /// `alone` is locked while f runs, and while an unused result is destroyed. `owner` is kept as long as f runs.
  InterruptibleWork(nb::object owner, std::timed_mutex& alone, F f)
      : owner_(std::move(owner)), alone_(alone), f_(std::move(f)) {}

  /// Runs the work. Called and left with the interpreter's lock.
  static Result run(std::shared_ptr<InterruptibleWork> work) {
    {
      const nb::gil_scoped_release no_interpreter;
      std::thread thread = start(work);
      try {
        work->wait();
      } catch (...) {
        if (thread.joinable()) work->is_abandoned_ ? thread.detach() : thread.join();
        throw;
      }
      if (thread.joinable()) thread.join();
    }
    if (work->problem_) std::rethrow_exception(work->problem_);
    return std::move(*work->result_);
  }

 private:
  static std::thread start(const std::shared_ptr<InterruptibleWork>& work) {
    try {
      return std::thread([own = std::shared_ptr<InterruptibleWork>(work)]() mutable {
        if (own->do_all()) return;
        {
          const nb::gil_scoped_acquire interpreter;
          own.reset();
        }
        AbandonedWork::end();
      });
    } catch (const std::system_error&) {
      work->do_all();  // no more threads can be started
      return {};
    }
  }

  /// Does the work. Returns whether the caller waits for the result.
  bool do_all() {
    const std::lock_guard alone(alone_);
    try {
      result_.emplace(f_());
    } catch (...) {
      problem_ = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    is_done_ = true;
    changed_.notify_all();
    if (is_abandoned_) result_.reset();
    return !is_abandoned_;
  }

  void wait() {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, kSignalInterval, [&] { return is_done_; })) {
      lock.unlock();
      try {
        check_signals();
      } catch (...) {
        abandon();
        throw;
      }
      lock.lock();
    }
  }
  void abandon() {
    const std::lock_guard alone_when_done(mutex_);
    if (is_done_) return;
    is_abandoned_ = true;
    AbandonedWork::begin();
  }

  nb::object owner_;
  std::timed_mutex& alone_;
  F f_;
  std::optional<Result> result_;
  std::exception_ptr problem_;

  std::mutex mutex_;  ///< guards the members below
  std::condition_variable changed_;
  bool is_done_ = false;
  bool is_abandoned_ = false;
};

}  // namespace softcd::python

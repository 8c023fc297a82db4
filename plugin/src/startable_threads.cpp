#include "startable_threads.hpp"

#include <fmt/format.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "softcd/core/parallel.hpp"

namespace softcd {
namespace {

/// Threads that only wait until all of them end.
class IdleThreads {
 public:
  IdleThreads() = default;
  IdleThreads(const IdleThreads&) = delete;
  IdleThreads& operator=(const IdleThreads&) = delete;
  ~IdleThreads() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      may_end_ = true;
    }
    ending_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  /// Starts at most `wanted` threads. Returns how many are running.
  std::size_t start(std::size_t wanted) {
    threads_.reserve(wanted);
    try {
      while (threads_.size() < wanted) {
        threads_.emplace_back([this] {
          std::unique_lock<std::mutex> lock(mutex_);
          ending_.wait(lock, [this] { return may_end_; });
        });
      }
    } catch (const std::system_error&) {
      // A thread could not be started: the threads before it are the limit.
    }
    return threads_.size();
  }

 private:
  std::mutex mutex_;
  std::condition_variable ending_;
  bool may_end_ = false;
  std::vector<std::thread> threads_;
};

/// The limit on oneTBB's threads, where one is needed, and the warning about it.
struct Limit {
  std::unique_ptr<parallel::ThreadLimit> control;
  std::string warning;
};

Limit limit_threads() {
  const std::size_t wanted = parallel::allowed_threads() - 1;
  const std::size_t startable = count_startable_threads(wanted);
  if (startable == wanted) return {};
  // Leave half of them to others, which may start threads before oneTBB does.
  const std::size_t taken = startable / 2;
  return {std::make_unique<parallel::ThreadLimit>(1 + taken),
          fmt::format("only {} of {} threads can be started; oneTBB goes on with {} beside the calling one. Raise the "
                      "limit on threads (ulimit -u, or the container's).",
                      startable, wanted, taken)};
}

}  // namespace

std::size_t count_startable_threads(std::size_t wanted) {
  return IdleThreads().start(wanted);
}

std::string keep_to_startable_threads() {
  // Never destroyed: objects that are destroyed later may still use oneTBB.
  static Limit* const limit = new Limit(limit_threads());
  static std::once_flag is_told;
  std::string warning;
  std::call_once(is_told, [&] { warning = std::move(limit->warning); });
  return warning;
}

}  // namespace softcd

#pragma once

#include <chrono>
#include <vector>

namespace softcd::demo {

/// What softcd takes of a step, in milliseconds.
struct StepProfile {
  double contacts = 0;   ///< finding contacts and handing them to Bullet
  double crossings = 0;  ///< with continuous detection: finding and preventing what would still pass through

  double total() const { return contacts + crossings; }
};

/// Measures through the zones that Bullet and softcd report to Bullet's profiler. One at a time, on the thread that
/// steps.
class StepProfiler {
 public:
  StepProfiler();
  ~StepProfiler();
  StepProfiler(const StepProfiler&) = delete;
  StepProfiler& operator=(const StepProfiler&) = delete;

  /// Of the steps since the last call.
  StepProfile take();

 private:
  struct Zone {
    double StepProfile::*part;  ///< null: none of ours
    std::chrono::steady_clock::time_point start;
  };

  static void enter(const char* name);
  static void leave();

  static StepProfiler* current_;
  void (*original_enter_)(const char*);
  void (*original_leave_)();
  StepProfile profile_;
  std::vector<Zone> open_zones_;
};

}  // namespace softcd::demo

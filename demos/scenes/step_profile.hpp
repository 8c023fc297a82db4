#pragma once

#include <chrono>
#include <vector>

namespace softcd::demo {

/// softcd's share of a step, in milliseconds.
struct StepProfile {
  double contacts = 0;    ///< finding contacts and handing them to Bullet
  double crossings = 0;   ///< with continuous detection: finding and preventing the remaining crossings
  double untangling = 0;  ///< with Settings::untangle

  double total() const { return contacts + crossings + untangling; }
};

/// Measures by the zones that Bullet and softcd report to Bullet's profiler. Only one may exist at a time, on the
/// thread that makes the steps.
class StepProfiler {
 public:
  StepProfiler();
  ~StepProfiler();
  StepProfiler(const StepProfiler&) = delete;
  StepProfiler& operator=(const StepProfiler&) = delete;

  /// Returns the profile of the steps since the last call.
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

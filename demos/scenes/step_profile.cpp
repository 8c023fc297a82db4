#include "scenes/step_profile.hpp"

#include <string_view>
#include <utility>

#include "LinearMath/btQuickprof.h"

namespace softcd::demo {
namespace {

double StepProfile::*part_of(std::string_view zone) {
  if (zone == "softcd contacts") return &StepProfile::contacts;
  if (zone == "softcd crossings") return &StepProfile::crossings;
  if (zone == "softcd untangling") return &StepProfile::untangling;
  return nullptr;
}

}  // namespace

StepProfiler* StepProfiler::current_ = nullptr;

StepProfiler::StepProfiler()
    : original_enter_(btGetCurrentEnterProfileZoneFunc()), original_leave_(btGetCurrentLeaveProfileZoneFunc()) {
  current_ = this;
  btSetCustomEnterProfileZoneFunc(enter);
  btSetCustomLeaveProfileZoneFunc(leave);
}

StepProfiler::~StepProfiler() {
  btSetCustomEnterProfileZoneFunc(original_enter_);
  btSetCustomLeaveProfileZoneFunc(original_leave_);
  current_ = nullptr;
}

StepProfile StepProfiler::take() {
  return std::exchange(profile_, {});
}

void StepProfiler::enter(const char* name) {
  current_->open_zones_.push_back({part_of(name), std::chrono::steady_clock::now()});
}

void StepProfiler::leave() {
  const Zone zone = current_->open_zones_.back();
  current_->open_zones_.pop_back();
  if (zone.part == nullptr) return;
  const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - zone.start;
  current_->profile_.*zone.part += elapsed.count();
}

}  // namespace softcd::demo

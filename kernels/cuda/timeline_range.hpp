#pragma once

#include <nvtx3/nvToolsExt.h>

namespace softcd {

/// Marks the host's work in the timelines of NVIDIA's tools (NVTX) for the lifetime of this object.
class TimelineRange {
 public:
  explicit TimelineRange(const char* label) { nvtxRangePushA(label); }
  TimelineRange(const TimelineRange&) = delete;
  TimelineRange& operator=(const TimelineRange&) = delete;
  ~TimelineRange() { nvtxRangePop(); }
};

}  // namespace softcd

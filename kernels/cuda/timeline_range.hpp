#pragma once

#include <nvtx3/nvToolsExt.h>

namespace softcd {

/// Shows what the host does while it lives in the timelines of NVIDIA's tools (NVTX).
class TimelineRange {
 public:
  explicit TimelineRange(const char* label) { nvtxRangePushA(label); }
  TimelineRange(const TimelineRange&) = delete;
  TimelineRange& operator=(const TimelineRange&) = delete;
  ~TimelineRange() { nvtxRangePop(); }
};

}  // namespace softcd

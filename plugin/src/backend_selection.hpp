#pragma once

#include <memory>

#include "softcd/pipeline/detector.hpp"
#include "softcd/softcd.hpp"

namespace softcd {

struct SelectedBackend {
  Backend backend;
  std::unique_ptr<Detector> detector;
  std::string reason;  ///< why this one, for explain()
};

/// Throws BackendError when `wanted` cannot be had.
SelectedBackend select_backend(Backend wanted);

}  // namespace softcd

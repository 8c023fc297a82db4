#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"

namespace softcd {

struct ClearWord {
  std::uint32_t* words;

  SOFTCD_HD void operator()(std::uint32_t i) const { words[i] = 0; }
};

}  // namespace softcd

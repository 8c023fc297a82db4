#pragma once

#include <cstdint>

#include "softcd/stages/vertex_stars.hpp"

namespace softcd::cpu {

/// Does the same as for_range() of lanes/volumes.hpp for stars. Tests several at once, in whatever registers the
/// processor has.
void for_range(const TestStar& test, std::uint32_t begin, std::uint32_t end);

}  // namespace softcd::cpu

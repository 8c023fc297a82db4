#include "hull_questions.hpp"

#include <fmt/format.h>

#include "validation.hpp"

namespace softcd::detail {

void HullsInQuestion::prepare(Span<const ProbeHull> hulls) {
  std::uint64_t point_count = 0;
  for (const ProbeHull& hull : hulls) {
    point_count += hull.points.size();
    if (point_count < kMostElements) continue;
    throw InvalidInput(fmt::format("{} hulls with {} points or more are more than 2^31; ask in several calls.",
                                   hulls.size(), point_count));
  }
  hulls_.clear();
  points_.clear();
  points_.reserve(point_count);
  for (const ProbeHull& hull : hulls) {
    hulls_.push_back(
        {static_cast<std::uint32_t>(points_.size()), static_cast<std::uint32_t>(hull.points.size()), hull.radius});
    points_.insert(points_.end(), hull.points.begin(), hull.points.end());
  }
}

}  // namespace softcd::detail

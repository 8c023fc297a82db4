#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "softcd/pipeline/detector.hpp"

namespace softcd {

/// Appends a range, or extends the last one where the two meet.
inline void append(std::vector<Range>& ranges, Range range) {
  if (range.begin == range.end) return;
  if (!ranges.empty() && ranges.back().end == range.begin) {
    ranges.back().end = range.end;
  } else {
    ranges.push_back(range);
  }
}

/// The elements of an array that a detector elsewhere does not have yet, in few ranges. Gaps between near ranges are
/// sent, too, because one more copy takes as long as some thousand elements.
class UnsentRanges {
 public:
  void add(std::uint64_t begin, std::uint64_t end) {
    if (begin == end) return;
    if (!ranges_.empty() && begin <= ranges_.back().end + kNear && ranges_.back().begin <= end + kNear) {
      Range& last = ranges_.back();
      last = {std::min(last.begin, begin), std::max(last.end, end)};
      return;
    }
    ranges_.push_back({begin, end});
    if (ranges_.size() < 2 * merged_count_ + kMostApart) return;
    merge(ranges_);
    merged_count_ = ranges_.size();
  }
  /// Adds all elements from `begin` on, whatever the array's later size.
  void add_from(std::uint64_t begin) { from_ = std::min(from_, begin); }
  /// Returns the ranges for an array of so many elements.
  std::vector<Range> within(std::uint64_t size) const {
    std::vector<Range> ranges = ranges_;
    ranges.push_back({from_, size});
    for (Range& range : ranges) range = {std::min(range.begin, size), std::min(range.end, size)};
    merge(ranges);
    return ranges;
  }
  /// Records that an array of so many elements has been sent.
  void clear(std::uint64_t size) noexcept {
    ranges_.clear();
    merged_count_ = 0;
    from_ = size;
  }

 private:
  static constexpr std::uint64_t kNear = 4096;
  static constexpr std::size_t kMostApart = 1024;

  static void merge(std::vector<Range>& ranges) {
    std::sort(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) { return a.begin < b.begin; });
    std::size_t count = 0;
    for (const Range& range : ranges) {
      if (range.begin >= range.end) continue;
      if (count > 0 && range.begin <= ranges[count - 1].end + kNear) {
        ranges[count - 1].end = std::max(ranges[count - 1].end, range.end);
      } else {
        ranges[count++] = range;
      }
    }
    ranges.resize(count);
  }

  std::vector<Range> ranges_;
  std::size_t merged_count_ = 0;
  std::uint64_t from_ = 0;
};

}  // namespace softcd

#pragma once

#include <cstdint>
#include <cstring>

#include "softcd/core/host_device.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd {

/// Counts of positive floats, four bins per octave: bin = sign-less exponent:8 | mantissa's top two bits:2. Integer
/// counts, so every order of counting gives the same histogram, and one value of 1e30 occupies one bin.
constexpr int kSizeBins = 1024;
constexpr int kBinsPerOctave = 4;
/// The last bin with a finite upper edge. The upper edge of the next one is infinity, whose octave is the last.
constexpr int kLastFiniteBin = kSizeBins - kBinsPerOctave - 2;

SOFTCD_HD inline std::uint32_t size_bin(float value) {
  std::uint32_t bits = 0;
  memcpy(&bits, &value, sizeof(bits));
  return (bits >> 21) & (kSizeBins - 1U);
}

/// Returns the lower edge of a bin.
SOFTCD_HD inline float size_bin_edge(std::uint32_t bin) {
  const std::uint32_t bits = bin << 21;
  float value = 0.0F;
  memcpy(&value, &bits, sizeof(value));
  return value;
}

/// Returns the mean of the values with each one cut to eight medians: a robust scale, to about 10 %. Returns 0 if there
/// are none. Sums are integers in units of 2^-28 of the cut, so that they do not depend on the order of summation.
template <class Team>
SOFTCD_HD float clipped_mean(Team& team, const std::uint32_t* bins) {
  const auto count_in = [bins](int bin) { return static_cast<std::uint64_t>(bins[bin]); };
  const std::uint64_t total = team.sum(kSizeBins, count_in);
  if (total == 0) return 0.0F;

  constexpr int kResolution = 28;
  const int median = team.first_exceeding(kSizeBins, total / 2, count_in);
  const int cut = smaller(median + 3 * kBinsPerOctave, kLastFiniteBin);
  const double unit = static_cast<double>(size_bin_edge(static_cast<std::uint32_t>(cut))) / (1 << kResolution);
  if (!(unit > 0.0)) return 0.0F;
  const std::uint64_t sum = team.sum(kSizeBins, [&](int bin) -> std::uint64_t {
    if (bins[bin] == 0) return 0;
    const auto representative = static_cast<std::uint32_t>(bin < cut ? bin : cut);
    const double lower = static_cast<double>(size_bin_edge(representative));
    const double upper = static_cast<double>(size_bin_edge(representative + 1));
    return bins[bin] * static_cast<std::uint64_t>(0.5 * (lower + upper) / unit);
  });
  return static_cast<float>(static_cast<double>(sum) * unit / static_cast<double>(total));
}

/// Returns an upper bound of the largest value counted, at most a quarter octave above it; 0 if there are none.
template <class Team>
SOFTCD_HD float largest_size(Team& team, const std::uint32_t* bins) {
  const std::uint64_t total = team.sum(kSizeBins, [bins](int bin) { return static_cast<std::uint64_t>(bins[bin]); });
  if (total == 0) return 0.0F;
  const int last =
      team.first_exceeding(kSizeBins, total - 1, [bins](int bin) { return static_cast<std::uint64_t>(bins[bin]); });
  return size_bin_edge(static_cast<std::uint32_t>(last) + 1U);
}

}  // namespace softcd

#pragma once

#include <cstdint>
#include <cstring>

#include "softcd/core/host_device.hpp"

namespace softcd {

/// Counts of positive floats, four bins per octave: bin = sign-less exponent:8 | mantissa's top two bits:2. Integer
/// counts, so every order of counting gives the same histogram, and one value of 1e30 occupies one bin.
constexpr int kSizeBins = 1024;

SOFTCD_HD inline std::uint32_t size_bin(float value) {
  std::uint32_t bits = 0;
  memcpy(&bits, &value, sizeof(bits));
  return (bits >> 21) & (kSizeBins - 1U);
}

/// The lower edge of a bin.
SOFTCD_HD inline float size_bin_edge(std::uint32_t bin) {
  const std::uint32_t bits = bin << 21;
  float value = 0.0F;
  memcpy(&value, &bits, sizeof(value));
  return value;
}

/// Mean of the values with each one cut to eight medians: a robust scale, to about 10 %. 0 when there are none.
/// Sums are kept as integers in units of 2^-28 of the cut, so that they do not depend on the order of summation.
SOFTCD_HD inline float clipped_mean(const std::uint32_t* bins) {
  std::uint64_t total = 0;
  for (int bin = 0; bin < kSizeBins; ++bin) total += bins[bin];
  if (total == 0) return 0.0F;

  std::uint64_t below = 0;
  int median = 0;
  while (below + bins[median] <= total / 2) below += bins[median++];

  constexpr int kOctave = 4;
  constexpr int kResolution = 28;
  const int cut = median + 3 * kOctave < kSizeBins - kOctave ? median + 3 * kOctave : kSizeBins - kOctave - 1;
  const double unit = static_cast<double>(size_bin_edge(static_cast<std::uint32_t>(cut))) / (1 << kResolution);
  if (!(unit > 0.0)) return 0.0F;
  std::uint64_t sum = 0;
  for (int bin = 0; bin < kSizeBins; ++bin) {
    const auto representative = static_cast<std::uint32_t>(bin < cut ? bin : cut);
    const double middle = 0.5 * (static_cast<double>(size_bin_edge(representative)) +
                                 static_cast<double>(size_bin_edge(representative + 1)));
    sum += bins[bin] * static_cast<std::uint64_t>(middle / unit);
  }
  return static_cast<float>(static_cast<double>(sum) * unit / static_cast<double>(total));
}

/// An upper bound of the largest value counted, at most a quarter octave above it.
SOFTCD_HD inline float largest_size(const std::uint32_t* bins) {
  for (int bin = kSizeBins - 1; bin >= 0; --bin) {
    if (bins[bin] != 0) return size_bin_edge(static_cast<std::uint32_t>(bin) + 1U);
  }
  return 0.0F;
}

}  // namespace softcd

#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "softcd/core/parallel.hpp"

/// Stable least-significant-digit radix sort of integer keys, with or without values. Digits in which all keys agree
/// cost one pass of counting and no move. Blocks count and scatter in parallel; the result does not depend on their
/// number.
namespace softcd {
namespace radix {

/// Fewer, larger digits pay once there are more keys than digits.
constexpr int kLargeDigitBits = 11;
constexpr int kSmallDigitBits = 8;
constexpr std::uint64_t kManyKeys = 4096;
using Histogram = std::array<std::uint64_t, std::size_t{1} << kLargeDigitBits>;

/// Replaces the counts of each block by those of the blocks before it. Stores the place of each digit's first key in
/// `begins`. Returns false if one digit has all keys. Runs along the digits, so that it takes a microsecond a block.
inline bool scan_counts(std::vector<Histogram>& blocks, Histogram& begins, std::size_t digits, std::uint64_t count) {
  std::fill_n(begins.begin(), digits, 0U);
  for (Histogram& block : blocks) {
    for (std::size_t digit = 0; digit < digits; ++digit) {
      const std::uint64_t before = begins[digit];
      begins[digit] += block[digit];
      block[digit] = before;
    }
  }
  std::uint64_t at = 0;
  for (std::size_t digit = 0; digit < digits; ++digit) {
    const std::uint64_t size = begins[digit];
    if (size == count) return false;
    begins[digit] = at;
    at += size;
  }
  return true;
}

/// Sorts by the lowest `bits` bits. move(from, to, is_flipped) moves a value along with its key. Returns true if the
/// result is in `scratch`.
template <class Key, class Move>
bool sort(Key* keys, Key* scratch, std::uint64_t count, int bits, const Move& move) {
  if (count < 2) return false;
  constexpr std::uint64_t kLeastBlock = 4096;
  const auto threads = std::uint64_t{parallel::concurrency()};
  const std::uint64_t block_count = std::clamp<std::uint64_t>(count / kLeastBlock, 1, threads);
  std::vector<Histogram> blocks(block_count);
  Histogram begins;  // NOLINT(cppcoreguidelines-pro-type-member-init): scan_counts() sets it
  const auto begin_of = [&](std::uint64_t block) { return count * block / block_count; };

  const auto for_each_block = [&](const auto& f) {
    if (block_count == 1) {
      f(std::uint64_t{0});
    } else {
      parallel::for_each(block_count, f);
    }
  };

  const int digit_bits = count < kManyKeys ? kSmallDigitBits : kLargeDigitBits;
  const std::size_t digits = std::size_t{1} << digit_bits;
  bool is_flipped = false;
  for (int shift = 0; shift < bits; shift += digit_bits) {
    const auto digit_of = [=](Key key) { return static_cast<std::size_t>(key >> shift) & (digits - 1); };
    const Key* from = is_flipped ? scratch : keys;
    Key* to = is_flipped ? keys : scratch;
    for_each_block([&](std::uint64_t block) {
      Histogram& histogram = blocks[block];
      std::fill_n(histogram.begin(), digits, 0U);
      for (std::uint64_t i = begin_of(block); i < begin_of(block + 1); ++i) ++histogram[digit_of(from[i])];
    });
    if (!scan_counts(blocks, begins, digits, count)) continue;
    for_each_block([&](std::uint64_t block) {
      Histogram& next = blocks[block];
      for (std::size_t digit = 0; digit < digits; ++digit) next[digit] += begins[digit];
      for (std::uint64_t i = begin_of(block); i < begin_of(block + 1); ++i) {
        const std::uint64_t place = next[digit_of(from[i])]++;
        to[place] = from[i];
        move(i, place, is_flipped);
      }
    });
    is_flipped = !is_flipped;
  }
  return is_flipped;
}

}  // namespace radix

/// Sorts keys. Returns true if they are in `scratch` then.
template <class Key>
bool radix_sort_keys(Key* keys, Key* scratch, std::uint64_t count, int bits) {
  return radix::sort(keys, scratch, count, bits, [](std::uint64_t, std::uint64_t, bool) {});
}

/// Sorts keys and their values. Returns true if they are in the scratches then.
template <class Key, class Value>
bool radix_sort_pairs(Key* keys, Key* key_scratch, Value* values, Value* value_scratch, std::uint64_t count, int bits) {
  return radix::sort(keys, key_scratch, count, bits, [&](std::uint64_t from, std::uint64_t to, bool is_flipped) {
    if (is_flipped) {
      values[to] = value_scratch[from];
    } else {
      value_scratch[to] = values[from];
    }
  });
}

}  // namespace softcd

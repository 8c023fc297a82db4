#pragma once

#include <cstdint>

#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/cell_ranges.hpp"
#include "softcd/stages/counting.hpp"

/// Brings the entries of each cell together without a sort. A bin has the entries of a few cells, and each entry is
/// counted in its bin when it is registered. Then the entries are laid into the bins. Each one counts those of its bin
/// that come before it. Tests need the entries of a cell side by side, but cells and bins may have any order.
namespace softcd {

/// The bins of entries: 2^bits. Nearby cells have different bins.
struct EntryBins {
  int bits;

  SOFTCD_HD std::uint32_t bin(std::uint32_t key) const {
    constexpr std::uint32_t kGoldenRatio = 0x9E3779B1U;
    return (kGoldenRatio * key_cell(key)) >> (32 - bits);
  }
  SOFTCD_HD std::uint64_t count() const { return std::uint64_t{1} << bits; }
};

/// Returns bins for at most so many entries: a fourth to an eighth as many. A cell has some 14 entries.
inline EntryBins plan_bins(std::uint64_t entries) {
  int bits = 1;
  while (bits < kCellBits && (std::uint64_t{8} << bits) < entries) ++bits;
  return {bits};
}

/// Entries in a bin beyond which sorting is faster.
constexpr std::uint32_t kLongBin = 1024;

/// Entries in all bins beyond which sorting is faster. The bins no longer fit into a GPU's caches then. An H200 took
/// 0.54 ms to register and sort the 2.5 million entries of 624,000 triangles, and 0.65 ms to lay them into bins; with
/// 16 times as many triangles, 7.8 and 14.4 ms.
constexpr std::uint64_t kMostEntriesInBins = std::uint64_t{1} << 21;

/// Stores entries, and counts each in its bin at once. For backends whose lists do not grow while a stage runs.
struct BinTarget {
  using Value = KeyedEntry;
  EntryTarget entries;
  EntryBins bins;
  std::uint32_t* counts;  ///< of the bins; null: counts nothing
  std::uint32_t* places;  ///< of the entries in their bins
  std::uint64_t* long_bins;

  SOFTCD_HD void store(std::uint64_t i, const KeyedEntry& value) const {
    entries.store(i, value);
    if (counts == nullptr) return;
    const std::uint32_t place = count_one_more(counts + bins.bin(value.key));
    places[i] = place;
    if (place == kLongBin) count_one_more(long_bins);
  }
};

/// Gives each bin places for its entries.
struct PlaceBin {
  const std::uint32_t* counts;
  std::uint64_t* begins;

  template <class Places>
  SOFTCD_HD void operator()(std::uint32_t bin, Places& places) const {
    begins[bin] = places.allocate(counts[bin]).begin();
  }
};

struct LayIntoBin {
  EntryBins bins;
  const std::uint64_t* begins;  ///< of the bins
  const std::uint32_t* places;
  const std::uint32_t* keys;
  const Entry* entries;
  EntryTarget laid;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const std::uint32_t key = keys[i];
    laid.store(begins[bins.bin(key)] + places[i], {key, entries[i]});
  }
};

/// Prepares the entries of each bin for their tests, as PrepareEntry does with sorted ones. Skips bins that are too
/// long: their entries will be sorted.
template <class Control, bool kSwept>
struct PrepareInBin {
  PrepareEntry<Control, kSwept> prepare;  ///< of entries in bins
  EntryBins bins;
  const std::uint64_t* begins;
  const std::uint32_t* counts;
  std::uint32_t* ordered_keys;

  template <class Cells>
  SOFTCD_HD void operator()(std::uint32_t j, Cells& cells) const {
    const std::uint32_t key = prepare.keys[j];
    const std::uint32_t bin = bins.bin(key);
    const auto begin = static_cast<std::uint32_t>(begins[bin]);
    const std::uint32_t end = begin + counts[bin];
    if (end - begin > kLongBin) return;
    const std::uint32_t cell = key & ~7U;
    const std::uint32_t rank_end = cell + partner_ranks<Control>(prepare.scene, key_rank(key));
    std::uint32_t before_cell = 0;
    std::uint32_t before_rank_end = 0;
    std::uint32_t before = 0;
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t other = prepare.keys[k];
      before_cell += other < cell ? 1U : 0U;
      before_rank_end += other < rank_end ? 1U : 0U;
      before += (other < key) | ((other == key) & (k < j)) ? 1U : 0U;
    }
    const std::uint32_t partners = smaller(before_rank_end, before) - before_cell;
    ordered_keys[begin + before] = key;
    if (before == before_cell) cells.push(j);
    prepare.write(begin + before, key, prepare.entries[j], begin + before_cell, partners);
  }
};

}  // namespace softcd

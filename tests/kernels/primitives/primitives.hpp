#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "softcd/core/count.hpp"
#include "softcd/core/host_device.hpp"
#include "softcd/core/span.hpp"
#include "softcd/pipeline/memory_account.hpp"
#include "softcd/pipeline/output.hpp"

namespace softcd::test {

/// Sizes around the number of items that blocks and warps take at a time, and more than one pass of a whole device
/// takes.
inline constexpr std::uint32_t kSizes[] = {0, 1, 31, 32, 33, 4096, 1000000};

/// Mixes all bits (lowbias32, Chris Wellons).
SOFTCD_HD inline std::uint32_t hashed(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7FEB352DU;
  x = (x ^ (x >> 15)) * 0x846CA68BU;
  return x ^ (x >> 16);
}

/// The primitives of Machine::Backend. A machine says
///   problem()               why the backend cannot be had, or nothing
///   make_backend(account)
///   copy_in(values, to)     from the host to the backend's memory, after everything enqueued
///   copy_out(from, count)   and back, as a vector
template <class Machine>
class Primitives : public testing::Test {
 protected:
  using Backend = typename Machine::Backend;
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  template <class T>
  using SortBuffer = typename Backend::template SortBuffer<T>;

  /// A list of at most `capacity` values and its counter.
  template <class T>
  struct List {
    Buffer<T> values;
    Buffer<std::uint64_t> counter;
    std::uint64_t capacity = 0;

    Appender<ArrayTarget<T>> appender() { return {{values.data()}, counter.data(), capacity}; }
    /// Returns the number of appended values, stored or not.
    std::uint64_t count() const { return Machine::copy_out(counter.data(), 1)[0]; }
    std::vector<T> stored() const { return Machine::copy_out(values.data(), std::min(count(), capacity)); }
  };

  void SetUp() override {
    const std::string problem = Machine::problem();
    if (!problem.empty()) GTEST_SKIP() << problem;
    backend_ = Machine::make_backend(account_);
  }

  Backend& backend() { return *backend_; }

  /// Uploads values into a buffer of at least one value, so that it has an address.
  template <class T>
  Buffer<T> uploaded(const std::vector<T>& values) {
    Buffer<T> buffer;
    buffer.reserve(backend(), std::max<std::uint64_t>(values.size(), 1), 0);
    backend().upload(buffer, Span<const T>(values));
    return buffer;
  }
  Buffer<std::uint64_t> one_count(std::uint64_t value) { return uploaded(std::vector<std::uint64_t>{value}); }

  template <class T>
  List<T> make_list(std::uint64_t capacity) {
    List<T> list;
    list.values.reserve(backend(), std::max<std::uint64_t>(capacity, 1), 0);
    list.counter = one_count(0);
    list.capacity = capacity;
    return list;
  }

 private:
  MemoryAccount account_;
  std::unique_ptr<Backend> backend_;
};

/// Returns the key of a unit of work: item:32 | unit:32, from high to low bits.
SOFTCD_HD constexpr std::uint64_t unit_key(std::uint32_t item, std::uint32_t unit) {
  return (static_cast<std::uint64_t>(item) << 32) | unit;
}

/// Returns whether the tests' filters admit the unit.
SOFTCD_HD inline bool passes(std::uint64_t key) {
  return hashed(static_cast<std::uint32_t>(key) + 31U * static_cast<std::uint32_t>(key >> 32)) % 4U == 0U;
}

/// Returns the number of units of an item: most have a few, some none, one in 1000 more than a block takes at a time.
SOFTCD_HD inline std::uint32_t unit_count(std::uint32_t item) {
  return item % 1000U == 30U ? 3000U : hashed(item) % 4U % 3U;
}

/// All units of items 0 <= i < item_count, counted one by one.
class UnitCounts {
 public:
  explicit UnitCounts(std::uint32_t item_count) : offsets_(item_count + 1, 0) {
    for (std::uint32_t i = 0; i < item_count; ++i) offsets_[i + 1] = offsets_[i] + unit_count(i);
    times_.resize(total());
  }

  /// Returns where each item's units begin.
  std::vector<std::uint64_t> begins() const { return {offsets_.begin(), offsets_.end() - 1}; }
  std::uint64_t total() const { return offsets_.back(); }

  void add(const std::vector<std::uint64_t>& keys) {
    for (const std::uint64_t key : keys) {
      const std::uint64_t item = key >> 32;
      ASSERT_LT(item + 1, offsets_.size());
      ASSERT_LT(offsets_[item] + (key & 0xFFFFFFFFU), offsets_[item + 1]) << "item " << item;
      ++times_[offsets_[item] + (key & 0xFFFFFFFFU)];
    }
  }

  /// Expects each unit that `is_wanted` once and no others. If some may be missing, because lists were full, expects no
  /// other and none twice.
  template <class IsWanted>
  void expect_only(const IsWanted& is_wanted, bool some_may_lack = false) const {
    for (std::uint32_t item = 0; item + 1 < offsets_.size(); ++item) {
      for (std::uint64_t at = offsets_[item]; at < offsets_[item + 1]; ++at) {
        const auto unit = static_cast<std::uint32_t>(at - offsets_[item]);
        const int wanted = is_wanted(unit_key(item, unit)) ? 1 : 0;
        ASSERT_TRUE(times_[at] == wanted || (some_may_lack && times_[at] == 0))
            << "unit " << unit << " of item " << item << " is there " << int(times_[at]) << " times";
      }
    }
  }

  template <class IsWanted>
  std::uint64_t count(const IsWanted& is_wanted) const {
    std::uint64_t wanted = 0;
    for (std::uint32_t item = 0; item + 1 < offsets_.size(); ++item) {
      for (std::uint32_t unit = 0; unit < offsets_[item + 1] - offsets_[item]; ++unit) {
        wanted += is_wanted(unit_key(item, unit)) ? 1U : 0U;
      }
    }
    return wanted;
  }

 private:
  std::vector<std::uint64_t> offsets_;
  std::vector<std::uint8_t> times_;
};

inline bool all_units(std::uint64_t /*key*/) {
  return true;
}

/// Expects `run(list)` to append the units that `is_wanted`. If half of them fit, it must store that half and count
/// all. It must append all to a list that has grown to the count. make_list(capacity) makes a list.
template <class MakeList, class IsWanted, class Run>
void expect_units_in_any_room(std::uint32_t item_count, const MakeList& make_list, const IsWanted& is_wanted,
                              const Run& run) {
  const std::uint64_t wanted = UnitCounts(item_count).count(is_wanted);
  std::uint64_t asked_for = wanted / 2;
  for (const bool is_short : {true, false}) {
    auto list = make_list(asked_for);
    run(list);
    asked_for = list.count();
    ASSERT_EQ(asked_for, wanted);
    UnitCounts units(item_count);
    units.add(list.stored());
    units.expect_only(is_wanted, is_short);
  }
}

}  // namespace softcd::test

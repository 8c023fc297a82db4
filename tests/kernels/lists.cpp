#include <gtest/gtest.h>

#include <cstdint>
#include <new>

#include "softcd/pipeline/workspace.hpp"

namespace softcd::test {
namespace {

struct NoBackend {};

/// A column that takes no memory.
struct Column {
  std::uint64_t length = 0;

  void reserve(NoBackend& /*backend*/, std::uint64_t bound, std::uint64_t /*kept*/) { length = bound; }
  void rewind() {}
  std::uint32_t* data() { return nullptr; }
};

using List32 = List<NoBackend, ChunkCounter<&ChunkCounts::pairs>, ArrayTarget<std::uint32_t>, Column>;

constexpr std::uint64_t kMost = 0xFFFFFFFF;

TEST(Lists, grow_as_far_as_32_bits_number_their_items) {
  for (const std::uint64_t wanted : {kMost / 4 * 3, kMost / 8 * 7, kMost - 1, kMost}) {
    NoBackend backend;
    List32 list;
    list.reserve(backend, wanted, 0);
    EXPECT_GE(list.capacity(), wanted);
    EXPECT_LE(list.capacity(), kMost);
    EXPECT_EQ(list.column<0>().length, list.capacity());
  }
}

TEST(Lists, that_32_bits_cannot_number_the_items_of_are_refused) {
  NoBackend backend;
  List32 list;
  list.reserve(backend, 1000, 0);
  const std::uint64_t capacity = list.capacity();
  for (const std::uint64_t wanted : {kMost + 1, 2 * kMost, ~std::uint64_t{0}}) {
    EXPECT_THROW(list.reserve(backend, wanted, 0), std::bad_alloc) << wanted;
    EXPECT_EQ(list.capacity(), capacity);
    EXPECT_EQ(list.column<0>().length, capacity);
  }
}

}  // namespace
}  // namespace softcd::test

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <new>

#include "expectations.hpp"
#include "mesh_generators.hpp"

// Only the CPU backend's buffers are allocated as arrays in a detection.
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

std::atomic<std::size_t> array_bytes{0};
std::atomic<std::size_t> most_array_bytes{0};
std::atomic<std::size_t> allowed_array_bytes{kNone};

}  // namespace

void* operator new[](std::size_t size) {
  void* const memory = std::malloc(size);
  const std::size_t held = array_bytes += malloc_usable_size(memory);
  if (memory == nullptr || held > allowed_array_bytes) {
    array_bytes -= malloc_usable_size(memory);
    std::free(memory);
    throw std::bad_alloc();
  }
  most_array_bytes = std::max<std::size_t>(most_array_bytes, held);
  return memory;
}
void operator delete[](void* memory) noexcept {
  array_bytes -= malloc_usable_size(memory);
  std::free(memory);
}
void operator delete[](void* memory, std::size_t /*size*/) noexcept {
  operator delete[](memory);
}

namespace softcd::test {
namespace {

/// The bytes that malloc adds to each of a backend's some fifty buffers.
constexpr std::size_t kRounding = 50 * 32;

class Allocations : public testing::TestWithParam<Detection> {
 protected:
  ~Allocations() override { allowed_array_bytes = kNone; }

  /// Returns a scene whose pairs need more memory than everything else; a large triangle is near all others.
  static Scene scene() {
    SoupOptions options;
    options.triangle_count = 700;
    options.half_extent = 0.2;
    options.largest = 0.6;
    options.size_ratio = 4.0;
    options.seed = 31;
    Mesh mesh = triangle_soup(options);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {{-9, -9, -9}, {9, -9, 0}, {0, 9, 9}});
    mesh.triangles.push_back({{first, first + 1, first + 2}});
    return {moving(mesh, scattered(mesh, 0.002, 9), everything(0.0001F))};
  }

  /// Returns a scene in which only few of many triangles have a near partner.
  static Scene mostly_apart() {
    SoupOptions options;
    options.triangle_count = 20000;
    options.half_extent = 500.0;
    options.largest = 0.1;
    options.seed = 32;
    const Mesh mesh = triangle_soup(options);
    return {moving(mesh, scattered(mesh, 0.002, 9), everything(0.0001F))};
  }

  static PipelineOptions cpu(std::uint64_t memory_limit) {
    PipelineOptions options;
    options.backend = Backend::cpu;
    options.detection = GetParam();
    options.memory_limit = memory_limit;
    return options;
  }
};

TEST_P(Allocations, are_what_the_limit_bounds_and_the_peak_counts) {
  const Outcome unlimited = outcome_of(scene(), cpu(0));
  ASSERT_GT(unlimited.contacts.size(), 50U);
  const Outcome plenty = outcome_of(scene(), cpu(1ULL << 40));
  for (const double share : {1.0, 0.8, 0.65}) {
    const auto limit = static_cast<std::uint64_t>(share * static_cast<double>(plenty.statistics.peak_bytes));
    const std::size_t before = array_bytes;
    most_array_bytes = before;
    const Outcome limited = outcome_of(scene(), cpu(limit));
    EXPECT_TRUE(identical(unlimited.contacts, limited.contacts));
    EXPECT_LE(most_array_bytes - before, limit + kRounding) << share;
    EXPECT_LE(limited.statistics.peak_bytes, most_array_bytes - before);
    EXPECT_GE(limited.statistics.peak_bytes + kRounding, most_array_bytes - before);
    EXPECT_EQ(array_bytes, before);
  }
}

// The capacity that a first detection guesses is no requirement: memory that suffices with a limit suffices without.
TEST_P(Allocations, need_not_suffice_for_the_first_guesses) {
  for (const Scene& tried : {scene(), mostly_apart()}) {
    const Outcome plenty = outcome_of(tried, cpu(1ULL << 40));
    const Outcome guessed = outcome_of(tried, cpu(0));
    const std::size_t needed = plenty.statistics.peak_bytes + kRounding;
    ASSERT_GT(guessed.statistics.peak_bytes, needed);
    allowed_array_bytes = array_bytes + needed;
    EXPECT_TRUE(identical(plenty.contacts, outcome_of(tried, cpu(0)).contacts));
    allowed_array_bytes = kNone;
  }
}

TEST_P(Allocations, that_fail_leave_a_pipeline_that_goes_on) {
  const Outcome unlimited = outcome_of(scene(), cpu(0));
  LoadedScene loaded = load(scene(), cpu(0));
  std::size_t refused = 0;
  for (std::size_t allowed = 1000; allowed < unlimited.statistics.peak_bytes; allowed *= 2) {
    allowed_array_bytes = array_bytes + allowed;
    try {
      EXPECT_TRUE(identical(unlimited.contacts, loaded.pipeline.detect()));
    } catch (const OutOfMemory&) {
      ++refused;
      EXPECT_LE(loaded.pipeline.query.statistics().peak_bytes, unlimited.statistics.peak_bytes);
    }
    allowed_array_bytes = kNone;
  }
  EXPECT_GT(refused, 3U);
  EXPECT_TRUE(identical(unlimited.contacts, loaded.pipeline.detect()));
}

INSTANTIATE_TEST_SUITE_P(Kinds, Allocations, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& test) { return test.param == Detection::dcd ? "dcd" : "ccd"; });

}  // namespace
}  // namespace softcd::test

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "expectations.hpp"
#include "few_threads.hpp"
#include "mesh_generators.hpp"
#include "softcd/core/parallel.hpp"
#include "startable_threads.hpp"

// Threads that cannot be started. Each test runs in a process of its own, because oneTBB's threads stay alive.
namespace softcd::test {
namespace {

/// The number of threads that oneTBB would start.
constexpr std::size_t kThreads = 8;

using Bytes = std::vector<std::byte>;

/// Returns a scene with enough work for each thread in every stage.
Scene soups() {
  Scene scene;
  for (const std::uint64_t seed : {1U, 2U}) {
    SoupOptions options;
    options.triangle_count = 400;
    options.half_extent = 1.5;
    options.largest = 0.2;
    options.size_ratio = 8.0;
    options.joined_share = 0.5;
    options.seed = seed;
    const Mesh mesh = triangle_soup(options);
    scene.push_back(moving(mesh, scattered(mesh, 0.1, seed), everything(0.01F)));
  }
  return scene;
}

template <class T>
void append(Span<const T> values, Bytes& bytes) {
  const auto* const first = reinterpret_cast<const std::byte*>(values.data());
  bytes.insert(bytes.end(), first, first + values.size() * sizeof(T));
}

/// Returns contacts and probe results of a scene that lives for some detections, and of one after it, with its
/// `warnings`.
Bytes live(std::vector<std::string>& warnings) {
  // Kept until the process ends: oneTBB may start more threads as soon as a limit is removed, for work that is already
  // done.
  static auto* const threads = new parallel::ThreadLimit(kThreads);
  static_cast<void>(threads);
  Bytes bytes;
  for (int life = 0; life < 2; ++life) {
    SceneOptions options;
    options.backend = Backend::cpu;
    softcd::Scene scene(options, [&](LogLevel level, std::string_view text) {
      if (level == LogLevel::warning) warnings.emplace_back(text);
    });
    const Scene bodies = soups();
    for (const SceneBody& body : bodies) {
      const auto count = static_cast<std::uint32_t>(body.x_t0.size());
      scene.set_positions(scene.add_body({body.triangles, count, body.settings}), body.x_t0, body.x_t1);
    }
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      QueryOptions of_query;
      of_query.detection = detection;
      Query query(scene, of_query);
      for (int times = 0; times < 3; ++times) append(query.detect(), bytes);
    }
    Probe probe(scene);
    const std::vector<ProbePoint> points(3000, {{0.3, -0.2, 0.1}});
    for (const ClosestPoint& nearest : probe.closest_points(points))
      append(Span<const double>(&nearest.distance, 1), bytes);
  }
  return bytes;
}

/// Checks that no start of oneTBB's threads was refused, however oneTBB would have handled that.
Bytes live_unrefused(std::size_t refused_at_first) {
  std::vector<std::string> warnings;
  Bytes bytes = live(warnings);
  if (refused_threads() != refused_at_first) throw Error("threads were refused that need not have been asked for");
  return bytes;
}

TEST(FailedThreads, are_done_without) {
  const std::optional<Bytes> expected = with_few_threads(100, [] { return live_unrefused(0); });
  ASSERT_TRUE(expected.has_value());
  ASSERT_GT(expected->size(), 1000 * sizeof(Contact));
  for (std::size_t most = 0; most <= kThreads; ++most) {
    const std::optional<Bytes> found =
        with_few_threads(most, [&] { return live_unrefused(most < kThreads - 1 ? 1 : 0); });
    ASSERT_TRUE(found.has_value()) << most << " threads: a crash, or an end that does not come";
    EXPECT_EQ(*found, *expected) << most << " threads";
  }
}

/// Returns the warnings when at most `most` threads can live.
std::string warned_with(std::size_t most) {
  const std::optional<Bytes> found = with_few_threads(most, [] {
    std::vector<std::string> warnings;
    live(warnings);
    std::string all;
    for (const std::string& warning : warnings) all += warning + '\n';
    Bytes bytes;
    append(Span<const char>(all.data(), all.size()), bytes);
    return bytes;
  });
  if (!found.has_value()) return "no end";
  return {reinterpret_cast<const char*>(found->data()), found->size()};
}

TEST(FailedThreads, are_warned_of_once) {
  EXPECT_EQ(warned_with(kThreads - 1), "");
  EXPECT_THAT(
      warned_with(kThreads - 2),
      testing::MatchesRegex("only 6 of 7 threads can be started; oneTBB goes on with 3 [^\n]*ulimit -u[^\n]*\n"));
}

TEST(FailedThreads, are_counted_before_they_are_needed) {
  const auto count = [](std::size_t wanted) { return [wanted] { return Bytes(count_startable_threads(wanted)); }; };
  EXPECT_EQ(with_few_threads(5, count(3)).value_or(Bytes(99)).size(), 3U);
  EXPECT_EQ(with_few_threads(5, count(7)).value_or(Bytes(99)).size(), 5U);
  EXPECT_EQ(with_few_threads(0, count(7)).value_or(Bytes(99)).size(), 0U);
}

}  // namespace
}  // namespace softcd::test

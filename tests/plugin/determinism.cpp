#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "backend_under_test.hpp"
#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "softcd/core/parallel.hpp"

namespace softcd::test {
namespace {

/// Returns a scene with split and large triangles, several bodies and self-collision.
Scene uneven_scene() {
  Scene scene;
  for (std::uint64_t i = 0; i < 3; ++i) {
    SoupOptions options;
    options.triangle_count = 600;
    options.half_extent = 2.5;
    options.largest = 3.0;
    options.size_ratio = 500.0;
    options.joined_share = 0.4;
    options.degenerate_share = 0.05;
    options.seed = 20 + i;
    const Mesh mesh = triangle_soup(options);
    scene.push_back(moving(mesh, scattered(mesh, 1.0, 30 + i), everything(0.005F)));
  }
  return scene;
}

class Determinism : public testing::TestWithParam<Detection> {};

TEST_P(Determinism, many_runs_of_one_pipeline) {
  const int runs = backend_under_test() == Backend::cuda ? 100 : 20;
  LoadedScene loaded = load(uneven_scene(), test_options(GetParam()));
  const Span<const Contact> first = loaded.pipeline.detect();
  const std::vector<Contact> expected(first.begin(), first.end());
  ASSERT_FALSE(expected.empty());
  for (int run = 1; run < runs; ++run) EXPECT_TRUE(identical(expected, loaded.pipeline.detect())) << "run " << run;
}

TEST_P(Determinism, fresh_pipelines) {
  const Scene scene = uneven_scene();
  const std::vector<Contact> expected = detect_once(scene, test_options(GetParam()));
  for (int run = 0; run < 3; ++run) EXPECT_TRUE(identical(expected, detect_once(scene, test_options(GetParam()))));
}

TEST_P(Determinism, any_number_of_threads) {
  const Scene scene = uneven_scene();
  const std::vector<Contact> expected = detect_once(scene, test_options(GetParam()));
  for (const std::size_t threads : {1U, 2U, 4U}) {
    const parallel::ThreadLimit limit(threads);
    EXPECT_TRUE(identical(expected, detect_once(scene, test_options(GetParam())))) << threads << " threads";
  }
}

TEST_P(Determinism, pipelines_in_threads_of_their_own) {
  const Scene scene = uneven_scene();
  const std::vector<Contact> expected = detect_once(scene, test_options(GetParam()));
  std::vector<std::vector<Contact>> found(3);
  std::vector<std::thread> threads;
  for (std::vector<Contact>& contacts : found) {
    threads.emplace_back([&] { contacts = detect_once(scene, test_options(GetParam())); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<Contact>& contacts : found) EXPECT_TRUE(identical(expected, contacts));
}

// Remains of an earlier, larger detection in the workspace must not change the result.
TEST_P(Determinism, after_other_scenes) {
  const Scene scene = uneven_scene();
  const std::vector<Contact> expected = detect_once(scene, test_options(GetParam()));
  LoadedScene loaded = load(scene, test_options(GetParam()));
  const Mesh sphere = icosphere(4, 2.0);
  const BodyId extra = loaded.pipeline.scene.add_body(
      {sphere.triangles, static_cast<std::uint32_t>(sphere.positions.size()), everything(0.1F)});
  loaded.pipeline.scene.set_positions(extra, sphere.positions);
  EXPECT_GT(loaded.pipeline.detect().size(), expected.size());
  loaded.pipeline.scene.remove_body(extra);
  EXPECT_TRUE(identical(expected, loaded.pipeline.detect()));
}

// CUDA has special values for the legacy default stream and the calling thread's stream. The CPU ignores them.
TEST_P(Determinism, callers_streams) {
  const Scene scene = uneven_scene();
  PipelineOptions options = test_options(GetParam());
  const std::vector<Contact> expected = detect_once(scene, options);
  for (const std::uintptr_t stream : {1U, 2U}) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): CUDA defines them so.
    options.cuda_stream = reinterpret_cast<void*>(stream);
    LoadedScene loaded = load(scene, options);
    for (int run = 0; run < 4; ++run) EXPECT_TRUE(identical(expected, loaded.pipeline.detect())) << "run " << run;
  }
}

// Runs with the CPU under test, and compares it with the GPU where there is one.
TEST_P(Determinism, cpu_and_cuda_return_the_same_bytes) {
  const std::string reason = why_missing(Backend::cuda);
  if (!reason.empty()) GTEST_SKIP() << reason;
  const Scene scene = uneven_scene();
  for (const BroadPhase broad_phase : {BroadPhase::exact, BroadPhase::uniform}) {
    for (const Accuracy accuracy : {Accuracy::fast, Accuracy::precise, Accuracy::conservative}) {
      PipelineOptions options = test_options(GetParam(), broad_phase);
      options.accuracy = accuracy;
      options.backend = Backend::cpu;
      const std::vector<Contact> expected = detect_once(scene, options);
      options.backend = Backend::cuda;
      LoadedScene loaded = load(scene, options);
      for (int run = 0; run < 5; ++run) EXPECT_TRUE(identical(expected, loaded.pipeline.detect())) << "run " << run;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Determinism, testing::Values(Detection::dcd, Detection::ccd),
                         [](const auto& test) { return test.param == Detection::dcd ? "dcd" : "ccd"; });

}  // namespace
}  // namespace softcd::test

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "lose_context.hpp"
#include "mesh_generators.hpp"
#include "scene_parts.hpp"

// The device's context is lost while a program runs, for example by a faulty kernel of the app. No CUDA call succeeds
// in that process any more, so each test runs this part in a process of its own.
namespace softcd::test {
namespace {

/// A scene of triangles that meet each other, and a question about it.
class OutlivingScene {
 public:
  explicit OutlivingScene(Backend backend)
      : scene_(scene_options(backend)), query_(scene_, looking_for(Detection::ccd)) {
    const BodyId id = scene_.add_body(desc_of(body_));
    scene_.set_positions(id, body_.x_t0, body_.x_t1);
  }

  Backend backend() const { return scene_.backend(); }
  std::vector<Contact> detect() { return copy_of(query_.detect()); }
  /// Returns whether a detection reports that the device has failed.
  bool is_told() {
    try {
      query_.detect();
    } catch (const BackendError& error) {
      std::cerr << error.what() << '\n';
      return true;
    }
    return false;
  }

 private:
  static SceneBody make_body() {
    SoupOptions options;
    options.triangle_count = 300;
    options.half_extent = 1.5;
    options.joined_share = 0.5;
    const Mesh mesh = triangle_soup(options);
    return moving(mesh, scattered(mesh, 0.3, 1), everything(0.03F));
  }

  SceneBody body_ = make_body();
  softcd::Scene scene_;
  Query query_;
};

/// Ends the process after everything of f's is destroyed; successfully where f() is true.
template <class F>
[[noreturn]] void exit_with(const F& f) {
  const bool holds = f();
  std::exit(holds ? EXIT_SUCCESS : EXIT_FAILURE);
}

class LostContexts : public testing::Test {
 protected:
  void SetUp() override {
    GTEST_FLAG_SET(death_test_style, "threadsafe");  // a new program, as CUDA does not work in a forked process
    const std::string reason = why_missing(Backend::cuda);
    if (!reason.empty()) GTEST_SKIP() << reason;
  }
};

TEST_F(LostContexts, are_told_of_by_every_detection_on_the_device) {
  const auto lose_and_detect = [] {
    OutlivingScene scene(Backend::cuda);
    const bool worked = identical(OutlivingScene(Backend::cpu).detect(), scene.detect());
    return worked && lose_cuda_context() && scene.is_told() && scene.is_told();
  };
  EXPECT_EXIT(exit_with(lose_and_detect), testing::ExitedWithCode(EXIT_SUCCESS), "CUDA");
}

TEST_F(LostContexts, leave_the_cpu_to_find_the_same_contacts) {
  const auto lose_and_detect = [] {
    OutlivingScene scene(Backend::automatic);
    const std::vector<Contact> expected = OutlivingScene(Backend::cpu).detect();
    const bool worked = !expected.empty() && identical(expected, scene.detect());
    return worked && lose_cuda_context() && identical(expected, scene.detect()) && scene.backend() == Backend::cpu;
  };
  EXPECT_EXIT(exit_with(lose_and_detect), testing::ExitedWithCode(EXIT_SUCCESS), "");
}

}  // namespace
}  // namespace softcd::test

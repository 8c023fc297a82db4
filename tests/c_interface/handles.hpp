#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "backend_under_test.hpp"
#include "softcd/softcd.h"

namespace softcd::test {

template <auto Destroy>
struct Destroys {
  template <class T>
  void operator()(T* handle) const {
    Destroy(handle);
  }
};
using ScenePointer = std::unique_ptr<softcd_scene, Destroys<softcd_scene_destroy>>;
using QueryPointer = std::unique_ptr<softcd_query, Destroys<softcd_query_destroy>>;
using ProbePointer = std::unique_ptr<softcd_probe, Destroys<softcd_probe_destroy>>;

/// A triangle, and another one with a corner 0.1 above it, 0.2 above at t0. Their margins are 0.1.
class TwoTriangles : public testing::Test {
 protected:
  TwoTriangles() {
    softcd_scene_options options{};
    EXPECT_EQ(softcd_scene_options_init(&options, sizeof options), SOFTCD_OK);
    options.backend = static_cast<softcd_backend>(backend_under_test());
    softcd_scene* created = nullptr;
    EXPECT_EQ(softcd_scene_create(&options, &created), SOFTCD_OK) << softcd_last_error();
    scene_.reset(created);
    softcd_query* query = nullptr;
    EXPECT_EQ(softcd_query_create(scene(), nullptr, &query), SOFTCD_OK);
    query_.reset(query);
    EXPECT_EQ(softcd_body_settings_init(&settings_, sizeof settings_), SOFTCD_OK);
    settings_.margin = 0.1F;
    settings_.self_collision = 0;
    settings_.edge_edge = 0;
    for (softcd_body* body : {&lower_, &upper_}) {
      EXPECT_EQ(softcd_scene_add_body(scene(), kTriangle, 1, 3, &settings_, body), SOFTCD_OK);
    }
    const softcd_positions lower = positions(kLower);
    const softcd_positions above = positions(kUpperT0);
    const softcd_positions upper = positions(kUpper);
    EXPECT_EQ(softcd_scene_set_positions(scene(), lower_, nullptr, &lower), SOFTCD_OK);
    EXPECT_EQ(softcd_scene_set_positions(scene(), upper_, &above, &upper), SOFTCD_OK);
  }

  static softcd_positions positions(const float* x) {
    return {sizeof(softcd_positions), SOFTCD_FLOAT32, SOFTCD_HOST, x, 3, 3 * sizeof(float), nullptr};
  }

  softcd_scene* scene() const { return scene_.get(); }
  softcd_query* query() const { return query_.get(); }

  /// Returns the number of contacts of a detection.
  std::uint64_t detect(softcd_pairs pairs = SOFTCD_PAIRS_ALL) const {
    const softcd_contact* contacts = nullptr;
    std::uint64_t count = 0;
    EXPECT_EQ(softcd_query_detect(query(), pairs, &contacts, &count), SOFTCD_OK) << softcd_last_error();
    EXPECT_TRUE(contacts != nullptr || count == 0);
    return count;
  }

  static constexpr std::uint32_t kTriangle[] = {0, 1, 2};
  static constexpr float kLower[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  static constexpr float kUpperT0[] = {0.25F, 0.25F, 0.2F, 0.25F, 0.5F, 5, 0.5F, 0.25F, 5};
  static constexpr float kUpper[] = {0.25F, 0.25F, 0.1F, 0.25F, 0.5F, 5, 0.5F, 0.25F, 5};

  ScenePointer scene_;
  QueryPointer query_;
  softcd_body_settings settings_{};
  softcd_body lower_ = SOFTCD_NO_BODY;
  softcd_body upper_ = SOFTCD_NO_BODY;
};

}  // namespace softcd::test

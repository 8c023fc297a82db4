// Arrays that are longer than 32 bits can number. They do not exist in memory: none is read.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "scene.hpp"

namespace softcd::test {
namespace {

constexpr std::uint64_t kTooMany = 1ULL << 31;

TEST(Sizes, a_body_of_2_31_elements_is_refused_before_it_is_read) {
  const Mesh pair{{{{0, 1, 2}}, {{3, 4, 5}}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {-1, 0, 0}, {0, -1, 0}}};
  const Scene scene = {still(pair, everything(0.01F))};
  LoadedScene loaded = load(scene, test_options(Detection::dcd));
  const std::vector<Contact> expected = detect_once(scene, test_options(Detection::dcd));
  ASSERT_FALSE(expected.empty());
  const Triangle triangle{{0, 1, 2}};
  const Segment segment{{0, 1}};
  const std::vector<BodyDesc> descs = {
      {Span<const Triangle>(&triangle, kTooMany), 3, {}},
      {Span<const Triangle>(&triangle, 1), static_cast<std::uint32_t>(kTooMany), {}},
      {Span<const Triangle>(&triangle, 1), 3, {}, -1, Span<const Segment>(&segment, kTooMany - 1)}};
  for (const BodyDesc& desc : descs) {
    try {
      loaded.pipeline.scene.add_body(desc);
      ADD_FAILURE() << "not refused";
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("are more than 2^31"));
    }
    EXPECT_THROW(loaded.pipeline.scene.update_body(loaded.ids[0], desc), InvalidInput);
  }
  EXPECT_TRUE(identical(loaded.pipeline.detect(), expected));
}

TEST(Sizes, a_batch_of_2_31_questions_is_refused_before_it_is_read) {
  softcd::Scene scene;
  Probe probe(scene);
  const Ray ray{};
  const ProbePoint point{};
  const ProbeSphere sphere{};
  EXPECT_THROW(probe.first_hits(Span<const Ray>(&ray, kTooMany)), InvalidInput);
  EXPECT_THROW(probe.all_hits(Span<const Ray>(&ray, kTooMany)), InvalidInput);
  EXPECT_THROW(probe.closest_points(Span<const ProbePoint>(&point, kTooMany)), InvalidInput);
  EXPECT_THROW(probe.overlaps(Span<const ProbeSphere>(&sphere, kTooMany)), InvalidInput);
  const Vec3d corner{0, 0, 0};
  const ProbeHull hulls[2] = {{Span<const Vec3d>(&corner, 1)}, {Span<const Vec3d>(&corner, kTooMany - 1)}};
  EXPECT_THROW(probe.overlaps(Span<const ProbeHull>(hulls, 2)), InvalidInput);
  EXPECT_EQ(probe.first_hits(Span<const Ray>(&ray, 1)).size(), 1U);
}

}  // namespace
}  // namespace softcd::test

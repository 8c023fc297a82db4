#include "viewer/picture_taker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <set>

namespace softcd::demo {
namespace {

constexpr int kWidth = 192;
constexpr int kHeight = 108;

std::unique_ptr<Scene> two_cloths(int steps) {
  SceneOptions options;
  options.size = 12;
  options.settings.backend = Backend::cpu;
  std::unique_ptr<Scene> scene = make_scene("two-cloths", options);
  for (int i = 0; i < steps; ++i) scene->step();
  return scene;
}

PictureOptions options_with(OverlayChoice overlays) {
  PictureOptions options;
  options.width = kWidth;
  options.height = kHeight;
  options.overlays = overlays;
  return options;
}

Image picture_of(const Scene& scene, OverlayChoice overlays = {}) {
  return PictureTaker(options_with(overlays)).take(scene);
}

/// Red, green and blue.
std::array<int, 3> pixel(const Image& image, int x, int y) {
  const std::uint8_t* first = image.rgb.data() + 3 * (static_cast<std::ptrdiff_t>(y) * image.width + x);
  return {first[0], first[1], first[2]};
}

template <class Predicate>
int count(const Image& image, Predicate predicate) {
  int found = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) found += predicate(pixel(image, x, y)) ? 1 : 0;
  }
  return found;
}

// The visible sides of the two cloths, at any brightness, and the greys of the floor.
bool is_orange(const std::array<int, 3>& c) {
  return c[0] > c[1] + c[1] / 4 && c[1] > c[2] + c[2] / 4;
}
bool is_blue(const std::array<int, 3>& c) {
  return c[2] > c[1] + c[1] / 5 && c[1] > c[0] + c[0] / 5;
}
bool is_grey(const std::array<int, 3>& c) {
  const auto [low, high] = std::minmax({c[0], c[1], c[2]});
  return high - low < 20;
}

int sum(const Image& image) {
  int total = 0;
  for (const std::uint8_t value : image.rgb) total += value;
  return total;
}

TEST(PictureTaker, shows_the_cloths_over_a_floor_with_the_sky_above) {
  const Image image = picture_of(*two_cloths(60));
  ASSERT_EQ(image.width, kWidth);
  ASSERT_EQ(image.height, kHeight);
  ASSERT_EQ(image.rgb.size(), std::size_t{3} * kWidth * kHeight);
  EXPECT_GT(count(image, is_orange), kWidth * kHeight / 10);
  EXPECT_GT(count(image, is_blue), kWidth * kHeight / 200);
  EXPECT_GT(count(image, is_grey), kWidth * kHeight / 4);
  // Rows go from top to bottom: the sky is brighter than the floor.
  EXPECT_GT(pixel(image, 2, 1)[0], pixel(image, 2, kHeight - 2)[0] + 20);
}

TEST(PictureTaker, gives_the_same_bytes_for_the_same_scene) {
  const std::unique_ptr<Scene> scene = two_cloths(30);
  PictureTaker taker(options_with({}));
  const Image first = taker.take(*scene);
  EXPECT_EQ(taker.take(*scene).rgb, first.rgb);
  EXPECT_EQ(picture_of(*scene).rgb, first.rgb);
}

TEST(PictureTaker, follows_the_scene) {
  const std::unique_ptr<Scene> scene = two_cloths(0);
  PictureTaker taker(options_with({}));
  const Image first = taker.take(*scene);
  for (int i = 0; i < 30; ++i) scene->step();
  EXPECT_NE(taker.take(*scene).rgb, first.rgb);
}

// The floor's checks have two greys. A soft edge of a shadow has many greys in between, and the shadow is half as dark.
TEST(PictureTaker, casts_shadows_with_soft_edges) {
  const Image image = picture_of(*two_cloths(60));
  std::set<int> greys;
  int darkest = 255;
  for (int y = kHeight / 2; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const std::array<int, 3> c = pixel(image, x, y);
      if (!is_grey(c)) continue;
      greys.insert(c[0]);
      darkest = std::min(darkest, c[0]);
    }
  }
  EXPECT_LT(darkest, 125);
  int between = 0;
  for (const int grey : greys) between += grey > darkest + 15 && grey < darkest + 50 ? 1 : 0;
  EXPECT_GT(between, 20);
}

TEST(PictureTaker, draws_edges_darker_than_faces) {
  const std::unique_ptr<Scene> scene = two_cloths(60);
  OverlayChoice wire;
  wire.wire = true;
  const Image without = picture_of(*scene);
  const Image with = picture_of(*scene, wire);
  for (std::size_t i = 0; i < with.rgb.size(); ++i) ASSERT_LE(with.rgb[i], without.rgb[i]) << i;
  EXPECT_LT(sum(with), sum(without) - kWidth * kHeight);
}

TEST(PictureTaker, draws_contacts) {
  const std::unique_ptr<Scene> scene = two_cloths(120);
  ASSERT_GT(scene->count_contacts(), 20U);
  OverlayChoice contacts;
  contacts.contacts = true;
  const auto is_green = [](const std::array<int, 3>& c) { return c[1] > c[0] + 30 && c[1] > c[2] + 30; };
  EXPECT_EQ(count(picture_of(*scene), is_green), 0);
  EXPECT_GT(count(picture_of(*scene, contacts), is_green), 20);
}

// A simulation that has diverged is shown as far as possible.
TEST(PictureTaker, leaves_out_triangles_that_are_not_finite) {
  const std::unique_ptr<Scene> scene = two_cloths(60);
  const Image image = picture_of(*scene);
  btSoftBody& upper = *scene->simulation().bodies().back();
  upper.m_nodes[0].m_x.setX(std::numeric_limits<btScalar>::quiet_NaN());
  upper.m_nodes[1].m_x.setY(std::numeric_limits<btScalar>::infinity());
  const Image with_holes = picture_of(*scene);
  int different = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    different += std::equal(&image.rgb[i], &image.rgb[i] + 3, &with_holes.rgb[i]) ? 0 : 1;
  }
  EXPECT_GT(different, 0);
  EXPECT_LT(different, kWidth * kHeight / 50);
}

TEST(PictureTaker, refuses_pictures_that_are_too_large) {
  PictureOptions options;
  options.width = 1 << 20;
  EXPECT_THROW(PictureTaker{options}, std::runtime_error);
}

}  // namespace
}  // namespace softcd::demo

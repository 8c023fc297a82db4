#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cstdint>
#include <cstdlib>
#include <set>
#include <string>
#include <vector>

#include "run_program.hpp"
#include "temporary_folder.hpp"

namespace softcd::test {
namespace {

struct Picture {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> rgb;

  const std::uint8_t* pixel(std::uint32_t x, std::uint32_t y) const { return &rgb[3 * (std::size_t{y} * width + x)]; }
};

Picture read_png(const std::string& file) {
  Picture picture;
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&header, file.c_str()) == 0) return picture;
  header.format = PNG_FORMAT_RGB;
  picture.rgb.resize(PNG_IMAGE_SIZE(header));
  if (png_image_finish_read(&header, nullptr, picture.rgb.data(), 0, nullptr) == 0) return {};
  picture.width = header.width;
  picture.height = header.height;
  return picture;
}

// The two sides of two-cloths' upper cloth, orange, and of the lower one, blue, however bright they are.
bool is_orange(const std::uint8_t* pixel) {
  return pixel[0] > pixel[1] + pixel[1] / 4 && pixel[1] > pixel[2] + pixel[2] / 4;
}
bool is_blue(const std::uint8_t* pixel) {
  return pixel[2] > pixel[1] + pixel[1] / 10 && pixel[1] > pixel[0] + pixel[0] / 10;
}

class Viewer : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v xvfb-run >/dev/null") != 0)
      GTEST_SKIP() << "there is no xvfb-run: apt-get install xvfb xauth";
  }

  // The program's window in a virtual display, drawn by the CPU.
  Result run(const std::string& arguments) const {
    const std::string in_display = "LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s '-screen 0 1600x1200x24' '" SOFTCD_DEMO "' ";
    return run_shell(in_display + arguments, folder_);
  }

  TemporaryFolder folder_;
};

TEST_F(Viewer, shows_the_cloths_and_closes) {
  const std::string file = folder_.file("window.png");
  const Result result = run("two-cloths --size 20 --backend cpu --view --view-frames 4 --screenshot " + file);
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const Picture picture = read_png(file);
  ASSERT_GE(picture.width, 640U);
  ASSERT_GE(picture.height, 400U);
  std::set<std::uint32_t> colors;
  std::size_t orange = 0;
  std::size_t blue = 0;
  for (std::uint32_t y = picture.height / 4; y < 3 * picture.height / 4; ++y) {
    for (std::uint32_t x = picture.width / 3; x < picture.width; ++x) {
      const std::uint8_t* pixel = picture.pixel(x, y);
      colors.insert(static_cast<std::uint32_t>(pixel[0] | pixel[1] << 8 | pixel[2] << 16));
      orange += is_orange(pixel) ? 1 : 0;
      blue += is_blue(pixel) ? 1 : 0;
    }
  }
  const std::size_t needed_positions = std::size_t{picture.height} / 2 * (picture.width - picture.width / 3);
  EXPECT_GT(colors.size(), 100U) << "shading";
  EXPECT_GT(orange, needed_positions / 10);
  EXPECT_GT(blue, needed_positions / 50);
  EXPECT_LT(orange + blue, needed_positions) << "the floor";
}

TEST_F(Viewer, draws_every_overlay) {
  const std::string plain = folder_.file("plain.png");
  ASSERT_EQ(run("two-cloths --size 16 --view --view-frames 12 --screenshot " + plain).exit_code, 0);
  const Picture without = read_png(plain);
  for (const char* overlay : {"contacts", "cells"}) {
    const std::string file = folder_.file(std::string(overlay) + ".png");
    const Result result = run("two-cloths --size 16 --view --view-frames 12 --overlays " + std::string(overlay) +
                              " --screenshot " + file);
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    const Picture with = read_png(file);
    ASSERT_EQ(with.rgb.size(), without.rgb.size());
    std::size_t different = 0;
    for (std::uint32_t y = 0; y < with.height; ++y) {
      for (std::uint32_t x = with.width / 3; x < with.width; ++x) {
        different += std::equal(with.pixel(x, y), with.pixel(x, y) + 3, without.pixel(x, y)) ? 0 : 1;
      }
    }
    EXPECT_GT(different, 1000U) << overlay;
  }
}

TEST(ViewerWithoutADisplay, says_so) {
  const TemporaryFolder folder;
  const Result result =
      run_shell("env -u DISPLAY -u WAYLAND_DISPLAY '" SOFTCD_DEMO "' two-cloths --size 8 --view", folder);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, testing::HasSubstr("no window can be opened"));
}

}  // namespace
}  // namespace softcd::test

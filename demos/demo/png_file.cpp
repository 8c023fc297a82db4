#include "png_file.hpp"

#include <fmt/format.h>
#include <png.h>

#include <stdexcept>

namespace softcd::demo {

void write_png(const std::filesystem::path& path, const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  if (png_image_write_to_file(&header, path.string().c_str(), /*convert_to_8bit=*/0, image.rgb.data(), /*row_stride=*/0,
                              /*colormap=*/nullptr) == 0) {
    throw std::runtime_error(
        fmt::format("{}: cannot be written ({}; does its folder exist?)", path.string(), header.message));
  }
}

}  // namespace softcd::demo

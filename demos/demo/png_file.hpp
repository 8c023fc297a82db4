#pragma once

#include <filesystem>

#include "viewer/image.hpp"

namespace softcd::demo {

/// Writes a PNG file. Throws std::runtime_error, naming the file, when it cannot be written.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace softcd::demo

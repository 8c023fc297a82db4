#pragma once

#include "rasterizer.hpp"
#include "scenes/scene.hpp"

namespace softcd::demo {

/// The scene as it is now, from its own point of view.
Image take_picture(const Scene& scene);

}  // namespace softcd::demo

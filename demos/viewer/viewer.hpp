#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "scenes/scene.hpp"
#include "viewer/overlays.hpp"

namespace softcd::demo {

/// 8-bit RGB, rows from top to bottom.
using TakeScreenshot = std::function<void(int width, int height, std::vector<std::uint8_t> rgb)>;

struct ViewerOptions {
  long frames = 0;  ///< after which the window closes by itself; 0: when the user closes it
  OverlayChoice overlays;
  TakeScreenshot take_screenshot;  ///< called with the last frame, where set
};

/// Shows the scene in a window until that is closed. Throws std::runtime_error when there is no display, no OpenGL 3.3,
/// or no viewer in this build; and as make_scene.
void run_viewer(const std::string& scene_name, const SceneOptions& scene_options, const ViewerOptions& options);

}  // namespace softcd::demo

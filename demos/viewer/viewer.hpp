#pragma once

#include <functional>
#include <string>

#include "scenes/scene.hpp"
#include "viewer/image.hpp"
#include "viewer/overlays.hpp"

namespace softcd::demo {

struct ViewerOptions {
  long frames = 0;  ///< after which the window closes by itself; 0: when the user closes it
  OverlayChoice overlays;
  std::function<void(const Image&)> take_screenshot;  ///< called with the last frame, where set
  /// Writes a picture that the user asks for, and returns the file's name.
  std::function<std::string(const Image&)> save_picture;
};

/// Shows the scene in a window until that is closed. Throws std::runtime_error when there is no display, no OpenGL 3.3,
/// or no viewer in this build; and as make_scene.
void run_viewer(const std::string& scene_name, const SceneOptions& scene_options, const ViewerOptions& options);

}  // namespace softcd::demo

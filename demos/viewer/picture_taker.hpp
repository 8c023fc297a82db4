#pragma once

#include <memory>

#include "scenes/scene.hpp"
#include "viewer/image.hpp"
#include "viewer/overlays.hpp"

namespace softcd::demo {

struct PictureOptions {
  int width = 1280;
  int height = 720;
  /// Overlays on the scene. Pictures have wire and contacts; the others are for the window only.
  OverlayChoice overlays;
};

/// Draws scenes as the window shows them, without a window, a display or a GPU. The same scene gives the same bytes on
/// one machine. Another machine with another OpenGL may round differently.
class PictureTaker {
 public:
  /// Throws std::runtime_error when there is no OpenGL 3.3, or this build cannot draw.
  explicit PictureTaker(const PictureOptions& options);
  ~PictureTaker();
  PictureTaker(const PictureTaker&) = delete;
  PictureTaker& operator=(const PictureTaker&) = delete;

  /// Draws the scene in its present state, from its own point of view.
  Image take(const Scene& scene);

 private:
  struct Renderer;

  PictureOptions options_;
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace softcd::demo

#pragma once

#include <memory>

#include "scenes/scene.hpp"
#include "viewer/image.hpp"
#include "viewer/overlays.hpp"

namespace softcd::demo {

struct PictureOptions {
  int width = 1280;
  int height = 720;
  /// What is drawn over the scene: wire and contacts. The others are the window's.
  OverlayChoice overlays;
};

/// Draws scenes as the window shows them, without a window, and without a display or a GPU. The same scene gives the
/// same bytes on one machine; others, with another OpenGL, round in other ways.
class PictureTaker {
 public:
  /// Throws std::runtime_error when there is no OpenGL 3.3, or this build cannot draw.
  explicit PictureTaker(const PictureOptions& options);
  ~PictureTaker();
  PictureTaker(const PictureTaker&) = delete;
  PictureTaker& operator=(const PictureTaker&) = delete;

  /// The scene as it is now, from its own point of view.
  Image take(const Scene& scene);

 private:
  struct Renderer;

  PictureOptions options_;
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace softcd::demo

#pragma once

namespace softcd::demo {

/// The part of the window that the scene is drawn in, in pixels: all of its height.
struct Viewport {
  int left, width, height;

  double aspect() const { return static_cast<double>(width) / height; }
};

}  // namespace softcd::demo

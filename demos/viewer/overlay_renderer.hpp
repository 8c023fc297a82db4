#pragma once

#include "viewer/gl_objects.hpp"
#include "viewer/overlays.hpp"

namespace softcd::demo {

/// Draws an OverlayGeometry over the scene. The scene's depths hide what lies behind them.
class OverlayRenderer {
 public:
  OverlayRenderer();

  void update(const OverlayGeometry& geometry);
  void draw(const OrbitCamera& camera, double aspect) const;

 private:
  GlProgram program_;
  GlMesh lines_, triangles_, bright_lines_;
};

}  // namespace softcd::demo

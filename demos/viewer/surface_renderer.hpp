#pragma once

#include "viewer/gl_objects.hpp"
#include "viewer/viewport.hpp"

namespace softcd::demo {

/// Draws a scene's surfaces on a checked floor under a sky, lit by one sun that casts shadows: the look of the
/// pictures that softcd-demo writes.
class SurfaceRenderer {
 public:
  SurfaceRenderer();

  /// Reads the nodes' positions.
  void update(const Scene& scene);
  void draw(const OrbitCamera& camera, const Viewport& viewport) const;

 private:
  /// Of one of the two sides each, so that front and back have colours of their own.
  struct Vertex {
    Vec3f position, normal, front, back;
  };

  void append(const Surface& surface);
  void draw_shadows() const;

  GlProgram surface_program_, background_program_, depth_program_;
  GlMesh mesh_, screen_;
  GlDepthMap shadows_;
  std::vector<Vertex> vertices_;
  Matrix4 light_{};         ///< from the scene to the shadow map
  double light_depth_ = 1;  ///< length of the shadow map's depth, in the scene's unit
  double floor_height_ = 0;
};

}  // namespace softcd::demo

#pragma once

#include "viewer/gl_objects.hpp"
#include "viewer/viewport.hpp"

namespace softcd::demo {

/// Draws a scene's surfaces on a checked floor under a sky, lit by one sun that casts soft shadows. Leaves out
/// triangles with vertices that are not finite. Draws pins at the nodes that hold a cloth.
class SurfaceRenderer {
 public:
  SurfaceRenderer();

  /// Reads the nodes' positions.
  void update(const Scene& scene);
  /// Draws the scene. `wire` draws the edges of all triangles, else only of the surfaces that want it.
  void draw(const OrbitCamera& camera, const Viewport& viewport, bool wire) const;

 private:
  /// A vertex of one of the two sides; front and back have colours of their own.
  struct Vertex {
    Vec3f position, normal, front, back;
    float has_edges_drawn;  ///< 0 or 1
  };

  void append(const Surface& surface);
  void append_pins(const btSoftBody& body);
  void draw_shadows() const;

  GlProgram surface_program_, background_program_, depth_program_;
  GlMesh mesh_, screen_;
  GlDepthMap shadows_;
  std::vector<Vertex> vertices_;
  Matrix4 light_{};               ///< from the scene to the shadow map
  Vec3d light_size_ = {1, 1, 1};  ///< of the shadow map's box, in the scene's unit
  double floor_height_ = 0;
};

}  // namespace softcd::demo

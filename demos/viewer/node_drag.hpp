#pragma once

#include <optional>
#include <vector>

#include "viewer/camera.hpp"

namespace softcd::demo {

/// Pulls one node of a scene's bodies along with the cursor, in the plane through where the node was taken that is
/// parallel to the screen.
class NodeDrag {
 public:
  /// The node keeps the distance that the cursor has from it now.
  void take(const std::vector<btSoftBody*>& bodies, std::size_t body, int node, const OrbitCamera& camera,
            const Ray& cursor);
  void release() { held_.reset(); }
  bool is_active() const { return held_.has_value(); }

  /// Where the cursor is now.
  void follow(const Ray& cursor);
  /// Before each step: gives the node a velocity towards its goal. What Bullet's solver makes of it, links and
  /// contacts included, is what happens.
  void pull(const std::vector<btSoftBody*>& bodies) const;

  struct Line {
    Vec3d node, goal;
  };
  /// While active.
  Line line(const std::vector<btSoftBody*>& bodies) const;

 private:
  struct Held {
    std::size_t body;
    int node;
    Vec3d taken_at, towards_screen;
    Vec3d cursor_at_first;  ///< in the plane
    Vec3d goal;
  };

  std::optional<Held> held_;
};

}  // namespace softcd::demo

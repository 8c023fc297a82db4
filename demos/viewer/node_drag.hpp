#pragma once

#include <optional>
#include <vector>

#include "viewer/camera.hpp"

namespace softcd::demo {

/// Pulls one node of a scene's bodies along with the cursor, in the plane that is parallel to the screen and passes
/// through the node's first position.
class NodeDrag {
 public:
  /// Starts to drag. The node keeps its present distance from the cursor.
  void take(const std::vector<btSoftBody*>& bodies, std::size_t body, int node, const OrbitCamera& camera,
            const Ray& cursor);
  void release() { held_.reset(); }
  bool is_active() const { return held_.has_value(); }

  /// Sets the cursor's present position.
  void follow(const Ray& cursor);
  /// Gives the node a velocity towards its goal, before each step. Bullet's solver then decides the motion, with links
  /// and contacts.
  void pull(const std::vector<btSoftBody*>& bodies) const;

  struct Line {
    Vec3d node, goal;
  };
  /// Returns the line from the node to the goal, while a node is dragged.
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

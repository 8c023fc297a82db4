#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "bodies/body_mesh.hpp"

namespace softcd::bullet {

/// Soft bodies in a scene on the CPU. A body's changes by the app are noticed whenever update() is called for it.
class SoftBodyScene {
 public:
  struct Member {
    btSoftBody* body = nullptr;
    BodyId id;
    BodyMesh mesh;
    std::vector<Vec3<btScalar>> positions;
  };

  explicit SoftBodyScene(LogCallback log);

  Scene& scene() { return scene_; }
  /// Brings the body up to date with its nodes' present positions.
  const Member& update(btSoftBody& body);
  /// Removes the bodies that are not among these, if there are more than these.
  void keep(Span<btSoftBody* const> all);
  /// Returns null if the body is unknown.
  const Member* find(const btSoftBody& body) const;
  /// Returns null if no soft body has the id.
  const Member* find(BodyId id) const;

 private:
  void set_mesh(Member& member, btSoftBody& body);
  void update_positions(Member& member, const btSoftBody& body);

  Scene scene_;
  std::unordered_map<const btSoftBody*, Member> members_;
  std::unordered_map<std::uint32_t, const Member*> members_by_id_;
};

}  // namespace softcd::bullet

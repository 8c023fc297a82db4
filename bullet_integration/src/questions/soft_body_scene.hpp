#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "bodies/body_mesh.hpp"

namespace softcd::bullet {

/// Soft bodies in a scene, on the CPU, as they are whenever they are asked for: what an app may have done to a body is
/// noticed then.
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
  /// The body with its nodes where they are now.
  const Member& update(btSoftBody& body);
  /// Forgets bodies that are not among these, once there are some.
  void keep(Span<btSoftBody* const> all);
  /// Null where it was not asked for, or is forgotten.
  const Member* find(const btSoftBody& body) const;
  /// Null where the id is none of a soft body.
  const Member* find(BodyId id) const;

 private:
  void set_mesh(Member& member, btSoftBody& body);
  void update_positions(Member& member, const btSoftBody& body);

  Scene scene_;
  std::unordered_map<const btSoftBody*, Member> members_;
  std::unordered_map<std::uint32_t, const Member*> members_by_id_;
};

}  // namespace softcd::bullet

#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "scenes/soft_world.hpp"
#include "scenes/surface_mesh.hpp"

namespace softcd::demo {

/// A rigid body with a triangle mesh as its shape.
struct MeshBody {
  SurfaceMesh mesh;
  btScalar mass = 0;
};

/// Soft bodies that start through each other, through themselves or through rigid meshes.
struct IntersectingBodies {
  const char* name;
  const char* description;
  /// Makes them around the origin, about a metre in size. `size` is the number of nodes along a cloth.
  std::vector<std::unique_ptr<btSoftBody>> (*make)(btSoftBodyWorldInfo&, World, int size);
  /// Makes the rigid meshes; null if there are none.
  std::vector<MeshBody> (*make_meshes)() = nullptr;
};

/// Rigid meshes in a world, with copies as soft bodies in no world.
class RigidMeshes {
 public:
  using AddRigid =
      std::function<btRigidBody&(std::unique_ptr<btCollisionShape>, const btVector3& center, btScalar mass)>;

  RigidMeshes(const IntersectingBodies& kind, btSoftBodyWorldInfo& world_info, const AddRigid& add_rigid);

  const std::vector<btRigidBody*>& bodies() const { return bodies_; }
  /// Appends the copies, at the present places of the meshes, for find_intersections().
  void append_copies(std::vector<const btSoftBody*>& bodies);

 private:
  std::vector<MeshBody> meshes_;
  std::vector<btRigidBody*> bodies_;
  std::vector<std::unique_ptr<btSoftBody>> copies_;
};

/// Returns all kinds.
const std::vector<IntersectingBodies>& intersecting_bodies();

/// Returns the kind of that name. Throws std::invalid_argument when there is none.
const IntersectingBodies& find_intersecting_bodies(const char* name);

}  // namespace softcd::demo

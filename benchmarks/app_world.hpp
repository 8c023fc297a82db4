#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "scenes/soft_world.hpp"
#include "scenes/surface_mesh.hpp"

class btRigidBody;
class btTriangleMesh;

namespace softcd::benchmarks {

/// Bullet's three worlds of soft bodies.
enum class AppWorldKind : std::uint32_t { soft_rigid, soft_multi_body, deformable };

struct AppMotion {
  double kinetic_energy = 0;    ///< of everything with mass, J
  double potential_energy = 0;  ///< in gravity, relative to the origin, J
  double farthest = 0;          ///< the largest distance of a node or a rigid body from the origin
};

/// A world of an app: Bullet's own or softcd's, with rigid bodies and meshes beside soft bodies.
class AppWorld {
 public:
  /// Makes the world; Bullet's own one without settings. Soft bodies get `iterations` as Config::piterations.
  AppWorld(AppWorldKind kind, const std::optional<bullet::Settings>& settings, int iterations);
  ~AppWorld();
  AppWorld(const AppWorld&) = delete;
  AppWorld& operator=(const AppWorld&) = delete;

  bool is_deformable() const { return world_.kind() == demo::World::deformable; }
  demo::SoftWorld& soft_world() { return world_; }
  btSoftBodyWorldInfo& info() { return world_.world_info(); }
  void set_gravity(const btVector3& gravity) { world_.set_gravity(gravity); }

  btSoftBody& add(std::unique_ptr<btSoftBody> body);
  btRigidBody& add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center, btScalar mass = 0);
  /// Adds a rigid triangle mesh, given around the origin. It does not move unless the app makes it kinematic.
  btRigidBody& add_mesh(const demo::SurfaceMesh& mesh, const btVector3& center);

  /// Shifts every soft body by up to 1 mm along each axis, differently for each `start`: chaotic apps then end
  /// differently.
  void shift_bodies(unsigned start);

  /// Makes one of Bullet's steps. The deformable world takes four of them for a step of a classic one.
  void step(btScalar seconds) { world_.step(seconds); }
  static constexpr btScalar kFrame = btScalar(1) / 60;
  int steps_per_frame() const { return is_deformable() ? 4 : 1; }

  /// Returns the number of edges of soft bodies and rigid meshes that intersect a triangle of another body, exactly.
  /// Edges within a body count where it collides with itself.
  std::size_t count_crossings();
  AppMotion motion();
  /// Returns the number of free bodies whose centre is below this height and below every held soft body, or not a
  /// number. A held body may sink far under its load.
  std::size_t count_lost(btScalar height) const;

 private:
  /// A soft body outside of the world with the shape and place of a rigid mesh.
  struct MeshImage {
    const btRigidBody* mesh;
    demo::SurfaceMesh shape;
    std::unique_ptr<btSoftBody> image;
  };

  int iterations_;
  std::vector<std::unique_ptr<btTriangleMesh>> triangles_;  ///< declared before the world, whose shapes refer to them
  demo::SoftWorld world_;
  std::vector<btRigidBody*> rigid_bodies_;
  std::vector<MeshImage> mesh_images_;
};

/// Makes a body of mass 0 kinematic in Bullet's usual way: it stays flagged as static, too.
void make_kinematic(btRigidBody& body);

}  // namespace softcd::benchmarks

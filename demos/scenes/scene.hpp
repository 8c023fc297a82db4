#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenes/soft_world.hpp"

namespace softcd::demo {

/// Who finds the contacts of a scene's soft bodies.
enum class Collision : std::uint32_t {
  softcd,
  bullet,
  off,  ///< nobody: soft bodies pass through each other
};

struct SceneOptions {
  World world = World::classic;
  Collision collision = Collision::softcd;
  PlugIn plug_in = PlugIn::one_line_world;  ///< of softcd, in the classic world
  bullet::Settings settings;                ///< of softcd
  int size = 0;                             ///< in the scene's unit; 0: its default, for make_scene() alone
  btScalar time_step = 0;                   ///< of the scene and of Bullet, seconds; 0: see Scene
  int iterations = 0;  ///< of Bullet's classic solver, Config::piterations of all bodies; 0: the scene's own
};

struct Color {
  float red, green, blue;  ///< 0 to 1, linear
};

/// A body to be drawn. The two sides of a cloth differ, so that folds can be told.
struct Surface {
  const btSoftBody* body;
  Color front, back;
  bool has_edges_drawn = false;
};

/// A camera that looks at `target`; the unit is the scene's, y is up.
struct View {
  btVector3 eye, target;
  btScalar field_of_view = btScalar(0.6);  ///< vertical, radians
  btScalar floor_height = 0;               ///< where the floor is drawn
};

/// What is where it should not be at the end of a step. None of the detector's code takes part in counting.
struct Penetration {
  /// On the wrong side of a surface: those with an edge that intersects a triangle, and those that have passed through
  /// altogether, which the scene knows: inside the ball, below the cloth that should hold them up, under the layer on
  /// which they were folded.
  std::size_t vertices = 0;
  std::size_t edges = 0;  ///< that intersect a triangle; exact, see find_intersections()
};

/// A simulation that shows something, in fixed steps: of kTimeStep unless SceneOptions::time_step says otherwise.
class Scene {
 public:
  static constexpr btScalar kTimeStep = btScalar(1) / 120;

  /// Throws std::invalid_argument where the size is not positive: make_scene() knows each scene's default.
  explicit Scene(const SceneOptions& options);
  virtual ~Scene() = default;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// In the deformable world a step of kTimeStep is several of Bullet's.
  void step();
  btScalar time() const { return btScalar(step_count_) * time_step_; }
  btScalar time_step() const { return time_step_; }

  /// Throws a soft ball into the scene. It collides like the other bodies; penetration is counted without it.
  void throw_ball(const btVector3& center, btScalar radius, const btVector3& velocity);

  /// Takes over the time, changes of bodies, thrown balls, and the nodes' positions and velocities, of the same scene
  /// in another world.
  void go_on_from(const Scene& other);

  Penetration count_penetration() const;
  std::size_t count_penetrating_vertices() const { return count_penetration().vertices; }

  /// Contacts that Bullet's solver was given in the last step.
  std::size_t count_contacts() const;

  virtual std::vector<Surface> surfaces() const = 0;
  /// The scene's own surfaces and the balls that were thrown.
  std::vector<Surface> all_surfaces() const;
  std::size_t count_triangles() const;
  virtual View view() const = 0;

  SoftWorld& simulation() { return simulation_; }
  const SoftWorld& simulation() const { return simulation_; }

 protected:
  /// Adds the body. Where nobody shall find its contacts it no longer asks for them.
  btSoftBody& add(std::unique_ptr<btSoftBody> body);
  /// Moves what moves by itself during the coming step.
  virtual void animate() {}
  /// Changes nodes, links and faces of its bodies as those of the same scene have been changed.
  virtual void repeat_changes(const Scene& /*other*/) {}
  /// Gives the body's first nodes the velocities with which they are at `goals` after the coming step.
  void send(btSoftBody& body, const std::vector<btVector3>& goals) const;
  static std::vector<btVector3> positions_of(const btSoftBody& body);
  /// Marks the vertices of `body` that have passed through something altogether.
  virtual void mark_passed_through(const btSoftBody& body, std::vector<bool>& marked) const = 0;

 private:
  struct ThrownBall {
    btSoftBody* body;
    btScalar radius;
  };

  SoftWorld simulation_;
  Collision collision_;
  int iterations_;
  btScalar time_step_;
  long bullets_steps_;  ///< in one step
  long step_count_ = 0;
  std::vector<ThrownBall> thrown_balls_;
};

struct SceneInfo {
  const char* name;
  const char* description;
  const char* size_unit;
  int smallest_size;
  int default_size;  ///< several steps a second on two cores
  int paper_size;    ///< about as many triangles as in Wong, Leach and Zambetta 2012; 0: not one of its scenes
  bool in_deformable_world;
  std::unique_ptr<Scene> (*make)(const SceneOptions& options);
  /// Bullet does not come to an end with the tree of faces of a cloth that has come apart.
  bool in_bullets_detection = true;
};

/// The scenes, the main one first.
const std::vector<SceneInfo>& scenes();

/// Null when there is no scene of that name.
const SceneInfo* find_scene(const std::string& name);

/// Throws std::invalid_argument when there is no scene of that name, or it cannot have that size, world or detection.
std::unique_ptr<Scene> make_scene(const std::string& name, SceneOptions options);

}  // namespace softcd::demo

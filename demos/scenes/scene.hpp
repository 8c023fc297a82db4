#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenes/soft_world.hpp"

namespace softcd::demo {

/// The detector of contacts between a scene's soft bodies.
enum class Collision : std::uint32_t {
  softcd,
  bullet,
  off,  ///< none: soft bodies pass through each other
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
  float red, green, blue;  ///< each from 0 to 1, linear
};

/// A body to be drawn. The two sides of a cloth have different colours, so that folds are visible.
struct Surface {
  const btSoftBody* body;
  Color front, back;
  bool has_edges_drawn = false;
};

/// A camera that looks at `target`; the unit is the scene's, y is up.
struct View {
  btVector3 eye, target;
  btScalar field_of_view = btScalar(0.6);  ///< vertical, radians
  btScalar floor_height = 0;               ///< the height at which the floor is drawn
};

/// Penetrations at the end of a step. None of the detector's code takes part in counting.
struct Penetration {
  /// Vertices on the wrong side of a surface. Counts vertices with an edge that intersects a triangle. Also counts
  /// vertices that have passed through altogether, as defined by the scene: inside the ball, below the cloth that
  /// should hold them up, or under the layer on which they were folded.
  std::size_t vertices = 0;
  std::size_t edges = 0;  ///< edges that intersect a triangle; exact, see find_intersections()
};

/// A simulation for demonstration, in fixed steps: of kTimeStep unless SceneOptions::time_step is set.
class Scene {
 public:
  static constexpr btScalar kTimeStep = btScalar(1) / 120;

  /// Throws std::invalid_argument where the size is not positive. make_scene() replaces 0 by the scene's default.
  explicit Scene(const SceneOptions& options);
  virtual ~Scene() = default;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// Makes a step. In the deformable world a step of kTimeStep is several of Bullet's steps.
  void step();
  btScalar time() const { return btScalar(step_count_) * time_step_; }
  btScalar time_step() const { return time_step_; }

  /// Throws a soft ball into the scene. It collides like the other bodies, but does not count in penetrations.
  void throw_ball(const btVector3& center, btScalar radius, const btVector3& velocity);

  /// Takes over the state of the same scene in another world: the time, changes of bodies, thrown balls, and the nodes'
  /// positions and velocities.
  void go_on_from(const Scene& other);

  Penetration count_penetration() const;
  std::size_t count_penetrating_vertices() const { return count_penetration().vertices; }

  /// Returns the number of contacts that Bullet's solver received in the last step.
  std::size_t count_contacts() const;

  virtual std::vector<Surface> surfaces() const = 0;
  /// Returns the scene's own surfaces and the thrown balls.
  std::vector<Surface> all_surfaces() const;
  std::size_t count_triangles() const;
  virtual View view() const = 0;

  SoftWorld& simulation() { return simulation_; }
  const SoftWorld& simulation() const { return simulation_; }

 protected:
  /// Adds the body. Without a detector, turns its soft contacts off.
  btSoftBody& add(std::unique_ptr<btSoftBody> body);
  /// Moves the bodies that the scene itself moves during the coming step.
  virtual void animate() {}
  /// Repeats the changes of nodes, links and faces of the same scene in another world.
  virtual void repeat_changes(const Scene& /*other*/) {}
  /// Gives the body's first nodes the velocities that bring them to `goals` in the coming step.
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
  long bullets_steps_;  ///< in one step of the scene
  long step_count_ = 0;
  std::vector<ThrownBall> thrown_balls_;
};

struct SceneInfo {
  const char* name;
  const char* description;
  const char* size_unit;
  int smallest_size;
  int default_size;  ///< runs at several steps a second on two cores
  int paper_size;    ///< about as many triangles as in Wong, Leach and Zambetta 2012; 0: the paper lacks this scene
  bool in_deformable_world;
  std::unique_ptr<Scene> (*make)(const SceneOptions& options);
  /// False where Bullet's tree of faces makes it loop for ever, because the cloth has come apart.
  bool in_bullets_detection = true;
  /// Whether bodies start through each other. Such a scene is not among those that are checked for intersections.
  bool starts_tangled = false;
};

/// Returns the scenes, the main one first.
const std::vector<SceneInfo>& scenes();

/// Returns the scene of that name, or null.
const SceneInfo* find_scene(const std::string& name);

/// Makes a scene. Throws std::invalid_argument when there is no scene of that name, or it cannot have that size, world
/// or detection.
std::unique_ptr<Scene> make_scene(const std::string& name, SceneOptions options);

}  // namespace softcd::demo

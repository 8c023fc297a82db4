#pragma once

#include "softcd/bullet/attach.hpp"
#include "worlds/hooked_broadphase.hpp"
#include "worlds/tick_callback.hpp"
#include "worlds/world_step.hpp"

namespace softcd::bullet {

/// In every kind of world.
inline constexpr Limitation kTreesLimitation = {
    Limit::updates_trees,
    "Bullet goes on updating the trees of the bodies' nodes, and those of faces that were there before, which nobody "
    "reads: a step takes longer than in softcd's own worlds."};
/// Where pairs are not seen.
inline constexpr Limitation kRigidMeshesLimitation = {
    Limit::leaves_rigid_meshes,
    "The world's dispatcher does not have pairs processed by the pair cache, so that contacts with rigid meshes are "
    "Bullet's, and none with convex shapes are added to its own."};

/// softcd in a world that somebody else made, from construction to detach(). What its own worlds do in functions that
/// they override is done where Bullet's step, which nobody can override from outside, calls something that can be set
/// through Bullet's public functions:
///
///     tick callback before the step    begin_step(), the app's, then prediction
///     broad phase                      before_pairs()
///     pair cache                       process_pairs(), in the dispatcher's dispatchAllCollisionPairs
///     tick callback                    the app's, then before_solver()
///
/// and what comes after Bullet's solver is where the derived classes find a place for it.
class AttachedWorld : protected BroadphaseHooks {
 public:
  /// Puts the hooks in. `bodies` are the world's, `kind` outlives it.
  AttachedWorld(btDynamicsWorld& world, const SoftBodies& bodies, const WorldKind& kind, const Settings& settings);
  virtual ~AttachedWorld() = default;  ///< detached
  AttachedWorld(const AttachedWorld&) = delete;
  AttachedWorld& operator=(const AttachedWorld&) = delete;

  /// Null where none is attached to it.
  static AttachedWorld* of(btDynamicsWorld& world);

  WorldDetection& detection() { return detection_; }
  bool is_attached() const { return world_ != nullptr; }
  virtual Span<const Limitation> limitations() const = 0;
  /// As Attachment's.
  void detach();
  void finish_step();

 protected:
  btDynamicsWorld& world() const { return *world_; }
  const SoftBodies& bodies() const { return bodies_; }
  WorldQueries& queries() const { return *detection_.queries_; }
  WorldStep step() const { return {*world_, bodies_, queries()}; }

  /// The face trees that are out of Bullet's sight between prepare_solver() and end_step(). None in classic worlds.
  FaceTreesAway& face_trees() { return face_trees_; }
  /// Contacts with rigid objects, and those of soft bodies where the kind of world has them now.
  virtual void process_step_pairs(const Processing& process_natively) = 0;
  /// The same, when the dispatcher has processed the pairs already and they did not come by.
  virtual void make_up_for_pairs() = 0;
  /// Between the app's tick callback and Bullet's solver.
  virtual void prepare_solver() = 0;
  /// When Bullet's solver has run.
  virtual void end_step(btScalar time_step) = 0;
  /// Whether nothing calls finish_step() in the step itself.
  virtual bool ends_steps_late() const = 0;
  virtual void remove_hooks();
  bool is_solved() const { return stage_ == Stage::is_solved; }
  btScalar step_length() const { return time_step_; }
  bool sees_pairs() const { return sees_pairs_; }

 private:
  static void call_pre_tick(btDynamicsWorld* world, btScalar time_step);
  static void call_tick(btDynamicsWorld* world, btScalar time_step);
  void begin_step();
  void start_over();
  void before_prediction();
  void begin_without_tick();
  void before_solver(btScalar time_step);
  void miss_pairs();

  void before_pairs() override;
  void process_pairs(const Processing& process_natively) override;
  void before_removal(const btCollisionObject& object) override;
  void before_ray_test() override {}
  void after_ray_test() noexcept override {}

  void leave_world();

  /// How far a step is that began with begin_step(), and was not finished.
  enum class Stage : std::uint32_t { none, begun, has_pairs, is_solved };

  btDynamicsWorld* world_;  ///< null when detached
  const btCollisionWorld& collision_world_;
  const SoftBodies& bodies_;
  TreeFlag tree_flag_;
  WorldDetection detection_;
  FaceTreesAway face_trees_;
  HookedBroadphase broadphase_;
  TickCallback pre_tick_, tick_;
  Stage stage_ = Stage::none;
  bool sees_pairs_;  ///< whether the dispatcher has them processed by the pair cache
  btScalar time_step_ = 0;
};

}  // namespace softcd::bullet

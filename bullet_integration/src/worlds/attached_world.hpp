#pragma once

#include "softcd/bullet/attach.hpp"
#include "worlds/app_callbacks.hpp"
#include "worlds/hooked_broadphase.hpp"
#include "worlds/step_driver.hpp"

namespace softcd::bullet {

/// Applies to every kind of world.
inline constexpr Limitation kTreesLimitation = {
    Limit::updates_trees,
    "Bullet still updates the trees of the bodies' nodes, and existing trees of faces, although nothing reads them: a "
    "step takes longer than in softcd's own worlds."};
/// Applies to worlds whose dispatcher bypasses the pair cache.
inline constexpr Limitation kRigidMeshesLimitation = {Limit::leaves_rigid_meshes,
                                                      "The world's dispatcher does not process pairs through the pair "
                                                      "cache: contacts with rigid meshes are Bullet's, and "
                                                      "softcd adds none with convex shapes."};

/// softcd in a world that other code has made, from construction to detach(). Bullet's step cannot be overridden from
/// outside. So softcd's part of the step runs in objects that Bullet's step calls and that public functions of Bullet
/// can set:
///
///     tick callback before the step    begin_step(), the app's, then prediction
///     broad phase                      before_pairs()
///     pair cache                       process_pairs(), in the dispatcher's dispatchAllCollisionPairs
///     tick callback                    the app's, then before_solver()
///
/// The derived classes find a place for the part after Bullet's solver.
class AttachedWorld : protected BroadphaseHooks {
 public:
  /// Installs the hooks. `bodies` are the world's. `kind` must outlive it.
  AttachedWorld(btDynamicsWorld& world, const SoftBodies& bodies, const WorldKind& kind, const Settings& settings);
  virtual ~AttachedWorld() = default;  ///< detached
  AttachedWorld(const AttachedWorld&) = delete;
  AttachedWorld& operator=(const AttachedWorld&) = delete;

  /// Returns null if none is attached to the world.
  static AttachedWorld* of(btDynamicsWorld& world);

  WorldDetection& detection() { return detection_; }
  bool is_attached() const { return world_ != nullptr; }
  virtual Span<const Limitation> limitations() const = 0;
  /// See Attachment::detach() and Attachment::finish_step().
  void detach();
  void finish_step();

 protected:
  btDynamicsWorld& world() const { return *world_; }
  Span<btSoftBody* const> bodies() const { return span_of(bodies_); }
  WorldQueries& queries() const { return *detection_.queries_; }
  template <class Step = StepDriver>
  Step step() const {
    return {*world_, bodies_, queries()};
  }

  /// Returns the face trees that are hidden from Bullet between prepare_solver() and end_step(). None in classic
  /// worlds.
  FaceTreesAway& face_trees() { return face_trees_; }
  /// Call the driver's moments. process_late() follows if the dispatcher has not used softcd's pair cache.
  virtual void process(const Processing& process_natively) = 0;
  virtual void process_late() = 0;
  /// Runs between the app's tick callback and Bullet's solver.
  virtual void prepare_solver() = 0;
  /// Runs after Bullet's solver.
  virtual void end_step(btScalar time_step) = 0;
  /// Returns whether nothing calls finish_step() within the step itself.
  virtual bool ends_steps_late() const = 0;
  virtual void remove_hooks();
  bool is_solved() const { return stage_ == Stage::is_solved; }
  btScalar step_length() const { return time_step_; }
  bool sees_pairs() const { return sees_pairs_; }

 private:
  static void call_pre_tick(btDynamicsWorld* world, btScalar time_step);
  static void call_tick(btDynamicsWorld* world, btScalar time_step);
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

  /// The progress of a step that has begun with begin_step() and is not finished.
  enum class Stage : std::uint32_t { none, begun, has_pairs, is_solved };

  btDynamicsWorld* world_;  ///< null when detached
  const btCollisionWorld& collision_world_;
  const SoftBodies& bodies_;
  WorldDetection detection_;
  FaceTreesAway face_trees_;
  HookedBroadphase broadphase_;
  PreTickCallback pre_tick_;
  TickCallback tick_;
  Stage stage_ = Stage::none;
  bool sees_pairs_;  ///< whether the dispatcher processes pairs by the pair cache
  btScalar time_step_ = 0;
};

}  // namespace softcd::bullet

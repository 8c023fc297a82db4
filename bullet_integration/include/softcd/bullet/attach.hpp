#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "BulletDynamics/Dynamics/btDynamicsWorld.h"
#include "softcd/bullet/world_detection.hpp"
#include "softcd/export.hpp"
#include "softcd/version.hpp"

namespace softcd::bullet {

class AttachedWorld;

inline namespace SOFTCD_VERSION_NAMESPACE {

/// A difference between an attached world and softcd's own world of that kind.
enum class Limit : std::uint32_t {
  updates_trees,    ///< Bullet still updates trees that are never read
  ends_steps_late,  ///< see Attachment::finish_step()
  /// Bullet alone finds contacts with rigid meshes and convex shapes, whatever the settings are.
  leaves_rigid_meshes,
};

/// One difference from softcd's own worlds, and a sentence about it.
struct Limitation {
  Limit limit;            ///< for programs
  std::string_view text;  ///< one sentence; its storage is static
};

class Attachment;
SOFTCD_EXPORT Attachment attach(btDynamicsWorld& world, const Settings& settings);

/// A connection of softcd to a world, made by attach(). Its destructor detaches.
class SOFTCD_EXPORT Attachment {
 public:
  Attachment(Attachment&&) noexcept;
  Attachment& operator=(Attachment&&) noexcept;
  /// Detaches. Unlike detach(), ignores exceptions of Settings::on_contacts and of OnError::throw_error.
  ~Attachment();

  /// Returns false after detach(), and after the world was destroyed with objects in it.
  bool is_attached() const;
  /// Finishes the step, removes softcd from the world and restores what it had replaced. Callable between steps, from
  /// tick callbacks and from actions; not while the world processes pairs, nor from the deformable world's solver
  /// callback. Throws what finish_step() throws, and is then detached, too. A second call does nothing.
  void detach();

  /// Finishes a step, if limitations() has Limit::ends_steps_late: Bullet's classic worlds call nothing after their
  /// solver of soft bodies. Runs the last pass of Detection::ccd, measures impulses, and calls Settings::on_contacts.
  ///
  /// Call it after stepSimulation and before you show or read positions. If you do not, the next step and detach()
  /// begin with it. Otherwise it does nothing. Nodes that the app moves between stepSimulation and this call move as
  /// part of the step, from m_q to m_x. Throws what a step throws: see OnError.
  void finish_step();

  /// Returns this attachment's differences from softcd's own worlds. They do not depend on the settings.
  Span<const Limitation> limitations() const;

  /// Returns the settings and results. The reference is valid as long as this object, or the one that it was moved to.
  /// After detach() it keeps the last results without their bodies.
  WorldDetection& detection();
  /// Returns the same.
  const WorldDetection& detection() const;

 private:
  friend Attachment attach(btDynamicsWorld& world, const Settings& settings);
  explicit Attachment(std::unique_ptr<AttachedWorld> attached);

  std::unique_ptr<AttachedWorld> attached_;
};

/// Adds softcd's detection to an existing world: a btSoftRigidDynamicsWorld, btSoftMultiBodyDynamicsWorld,
/// btDeformableMultiBodyDynamicsWorld, or a class derived from one of them. The world may be new or have run, with or
/// without bodies. If called in the middle of stepSimulation, softcd begins with the next step.
///
///     softcd::bullet::Attachment attachment = softcd::bullet::attach(*world);
///     for (const softcd::bullet::Limitation& limitation : attachment.limitations()) ...
///
/// Contacts, motion and results equal those of softcd's own worlds (soft_worlds.hpp, deformable_world.hpp). Bodies may
/// come and go, and settings may change.
///
/// While attached:
/// - world.getBroadphase() and getPairCache() return softcd's, which forward to the originals. Do not keep these
///   pointers, and do not call setBroadphase().
/// - softcd calls the app's tick callbacks. The app may set others. A step that was not finished by then misses its
///   last pass, and WorldDetection::crossing_report().failed_steps() counts it.
/// - softcd calls the app's solver callback, too, which the deformable world has. With ReadOut::impulses, softcd
///   responds to contacts between soft bodies itself after Bullet's solver, one at a time.
/// - The deformable world has one more action. Actions that the app added earlier see nodes before the last pass of
///   Detection::ccd. Removing softcd's action changes the order of actions added later.
///
/// Some dispatchers do not process pairs through the pair cache, for example btCollisionDispatcherMt. Bullet then
/// handles rigid meshes and convex shapes alone, and limitations() says so. softcd notices an app's own dispatcher of
/// this kind in the first step, and counts it in failed_steps() of rigid_mesh_report() and convex_shape_report().
///
/// Detach before you destroy the world. If a world is destroyed with objects in it, softcd notices and touches it no
/// more; it cannot notice the end of an empty world.
///
/// Throws InvalidInput if the world is none of these classes, or if softcd detects in it already; InvalidInput for
/// settings out of range; BackendError for a backend that is not there. The world is then unchanged.
[[nodiscard]] SOFTCD_EXPORT Attachment attach(btDynamicsWorld& world, const Settings& settings = {});

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet

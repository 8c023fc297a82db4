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

/// What softcd does not do in a world that it is attached to, and does in its own world of that kind.
enum class Limit : std::uint32_t {
  updates_trees,                    ///< Bullet's trees, which nobody reads, are updated all the same
  ends_steps_late,                  ///< see Attachment::finish_step()
  no_impulses_between_soft_bodies,  ///< BodyPairContacts::has_impulses is false for pairs of them
  /// To Bullet, whatever Settings::rigid_meshes is; and adds none to Bullet's contacts with convex shapes.
  leaves_rigid_meshes,
};

/// One thing that softcd does not do in a world that it is attached to.
struct Limitation {
  Limit limit;            ///< for programs
  std::string_view text;  ///< one sentence, of static storage
};

class Attachment;
SOFTCD_EXPORT Attachment attach(btDynamicsWorld& world, const Settings& settings);

/// softcd in a world that somebody else made: see attach(). Destroying it detaches.
class SOFTCD_EXPORT Attachment {
 public:
  Attachment(Attachment&&) noexcept;
  Attachment& operator=(Attachment&&) noexcept;
  /// As detach(), but that exceptions of Settings::on_contacts and with OnError::throw_error are swallowed.
  ~Attachment();

  /// False after detach(), and when the world was destroyed with objects in it.
  bool is_attached() const;
  /// Finishes the step, takes everything of softcd's out of the world, and puts back what stood there. May be called
  /// between steps, from the world's tick callbacks and from actions; not while it processes pairs, nor from the
  /// deformable world's solver callback. Throws as finish_step(), and is detached then, too. Does nothing the second
  /// time.
  void detach();

  /// Where `limitations()` has Limit::ends_steps_late: does what is left to do when Bullet's solver of soft bodies has
  /// run, in which no public function of Bullet's lets anybody. With Detection::ccd nothing is through anything after
  /// it; impulses are known, and Settings::on_contacts was called. The world's next step, and detach(), begin with it
  /// where nobody has called it. To be called after stepSimulation by who shows or reads positions then; else does
  /// nothing. What the app does to the nodes between stepSimulation and this is a part of the step: a node that was
  /// moved by its m_x alone counts as having gone there from its m_q. Throws as a step: see OnError.
  void finish_step();

  /// Of this attachment, whatever the settings are.
  Span<const Limitation> limitations() const;

  /// Valid as long as this, or what it was moved to. Detached it keeps its last results, but no bodies.
  WorldDetection& detection();
  /// The same.
  const WorldDetection& detection() const;

 private:
  friend Attachment attach(btDynamicsWorld& world, const Settings& settings);
  explicit Attachment(std::unique_ptr<AttachedWorld> attached);

  std::unique_ptr<AttachedWorld> attached_;
};

/// Gives a world that somebody else made softcd's detection: a btSoftRigidDynamicsWorld, btSoftMultiBodyDynamicsWorld
/// or btDeformableMultiBodyDynamicsWorld, or of a class derived from one of them. It may be new or have run, with
/// bodies or without. From a tick callback or an action of the world's, in the middle of stepSimulation, it begins with
/// the step after.
///
///     softcd::bullet::Attachment attachment = softcd::bullet::attach(*world);
///     for (const softcd::bullet::Limitation& limitation : attachment.limitations()) ...
///
/// Contacts, and what Bullet's solver makes of them, are as in softcd's own worlds (soft_worlds.hpp,
/// deformable_world.hpp), and so is what WorldDetection says. Bodies may come and go, and settings may change.
///
/// While it is attached, world.getBroadphase() and getPairCache() are softcd's, which pass everything on to the
/// original ones, go with the Attachment, and are not to be kept; setBroadphase() is not to be called. The app's tick
/// callbacks are called as ever, and it may set others: where a step ends late and was not finished then, the look at
/// crossings is missed, which counts in WorldDetection::crossings().failed_steps(). In the deformable world an action
/// is added. Actions that the app has added before see nodes that Detection::ccd holds back where they were going; the
/// order of actions that it adds afterwards changes when the attachment's is removed.
///
/// A dispatcher that does not have pairs processed by the pair cache, as btCollisionDispatcherMt, leaves rigid meshes
/// and convex shapes to Bullet. Of Bullet's the limitations say so; one of the app's is noticed in the first step, from
/// which on they do, and which counts in failed_steps() of WorldDetection::rigid_meshes() and convex_shapes().
///
/// Detach before the world is destroyed. A world that is destroyed with objects in it is noticed, and nothing of it is
/// touched afterwards; nobody tells softcd of an empty one.
///
/// Throws InvalidInput where the world is none of these, and where softcd is there already: attached, as one of
/// softcd's own worlds, or as a softcd::bullet::Dispatcher; and as CollisionPipeline's constructor. The world is then
/// as it was.
[[nodiscard]] SOFTCD_EXPORT Attachment attach(btDynamicsWorld& world, const Settings& settings = {});

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet

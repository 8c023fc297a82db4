#pragma once

#include <vector>

#include "tangles.hpp"

namespace softcd::bullet {

/// Finds the vertex-face contacts of a world's soft bodies, all in one batch: start() when Bullet has predicted,
/// finish() before its solver.
class ContactDetection {
 public:
  /// `kind` outlives it.
  ContactDetection(const WorldKind& kind, const Settings& settings);
  ContactDetection(const ContactDetection&) = delete;
  ContactDetection& operator=(const ContactDetection&) = delete;

  void set_settings(const Settings& settings);
  const CollisionPipeline& pipeline() const { return pipeline_; }
  const std::vector<EdgeContact>& edge_contacts() const { return edge_contacts_; }

  /// Reads the bodies that have the world's flag and starts the detection. The rule is asked during the call.
  void start(Span<btSoftBody* const> bodies, const PairRule& rule);
  /// Waits for the detection and writes its contacts into the bodies, which have not changed meanwhile.
  void finish();

  /// Removes the face trees that Bullet's prediction built; see FaceTreeWatch. Between start() and finish().
  void drop_unread_face_trees();

 private:
  void synchronize(btSoftBody& body);
  void set_positions(const SoftBodyRegistry::Member& member);
  void find_tangles(Span<const Contact> contacts);
  void write(const MemberContact& found) const;

  const WorldKind& kind_;
  Settings settings_;
  CollisionPipeline pipeline_;
  SoftBodyRegistry registry_;
  const PairRule* rule_ = nullptr;
  std::vector<EdgeContact> edge_contacts_;
  TangledNodes tangled_;
};

}  // namespace softcd::bullet

#pragma once

#include <vector>

#include "contact_writer.hpp"
#include "pair_gate.hpp"
#include "softcd/bullet/settings.hpp"
#include "tangles.hpp"

namespace softcd::bullet {

/// Finds the vertex-face contacts of a world's soft bodies, all in one batch: start() after Bullet's prediction,
/// finish() before its solver.
class SoftSoftDetection {
 public:
  explicit SoftSoftDetection(const Settings& settings);
  SoftSoftDetection(const SoftSoftDetection&) = delete;
  SoftSoftDetection& operator=(const SoftSoftDetection&) = delete;

  const Settings& settings() const { return settings_; }
  void set_settings(const Settings& settings);
  const CollisionPipeline& pipeline() const { return pipeline_; }
  const std::vector<EdgeContact>& edge_contacts() const { return edge_contacts_; }

  /// Reads the bodies that have VF_SS and starts the detection. The gate is asked about pairs during the call.
  void start(Span<btSoftBody* const> bodies, const PairGate& gate);
  /// Waits for the detection and writes its contacts into the bodies, which have not changed meanwhile.
  void finish();

  /// Removes the face trees that Bullet's prediction built; see FaceTreeWatch. Between start() and finish().
  void drop_unread_face_trees();

 private:
  void synchronize(btSoftBody& body);
  void find_tangles(Span<const Contact> contacts);
  void write(const MemberContact& found);

  Settings settings_;
  CollisionPipeline pipeline_;
  SoftBodyRegistry registry_;
  const PairGate* gate_ = nullptr;
  std::vector<EdgeContact> edge_contacts_;
  TangledNodes tangled_;
};

}  // namespace softcd::bullet

#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include "native_trees.hpp"
#include "pair_gate.hpp"
#include "snapshot_reader.hpp"
#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

/// Finds the vertex-face contacts of a world's soft bodies, all in one batch: start() after Bullet's prediction,
/// finish() before its solver. What an app may do to its bodies between two steps (adding, removing, deleting them,
/// new faces, flags, margins) is noticed in start().
class SoftSoftDetection {
 public:
  explicit SoftSoftDetection(const Settings& settings);
  SoftSoftDetection(const SoftSoftDetection&) = delete;
  SoftSoftDetection& operator=(const SoftSoftDetection&) = delete;

  const Settings& settings() const { return settings_; }
  void set_settings(const Settings& settings);
  const CollisionPipeline& pipeline() const { return pipeline_; }

  /// Reads the bodies that have VF_SS and starts the detection. The gate is asked about pairs during the call.
  void start(Span<btSoftBody* const> bodies, const PairGate& gate);
  /// Waits for the detection and writes its contacts into the bodies, which have not changed meanwhile.
  void finish();

  /// Removes the face trees that Bullet's prediction built; see FaceTreeWatch. Between start() and finish().
  void drop_unread_face_trees();

 private:
  struct Member {
    btSoftBody* body = nullptr;
    BodyId id;
    BodyMesh mesh;
    BodySettings settings;
    FaceTreeWatch face_tree;
    bool topology_changed = false;
    std::uint64_t last_step = 0;
  };

  PairFilter pair_filter();
  void synchronize(btSoftBody& body);
  Member& add_member(btSoftBody& body, const BodySettings& settings);
  void update_member(Member& member, const BodySettings& settings);
  void remove_absent_members();
  Member& member(BodyId id) const { return *members_by_id_.at(id.value); }

  Settings settings_;
  CollisionPipeline pipeline_;
  std::unordered_map<const btSoftBody*, Member> members_;
  std::unordered_map<std::uint32_t, Member*> members_by_id_;
  const PairGate* gate_ = nullptr;
  std::uint64_t step_ = 0;
};

}  // namespace softcd::bullet

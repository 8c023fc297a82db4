#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bodies/body_key.hpp"
#include "bodies/convex_core.hpp"
#include "bodies/node_ends.hpp"
#include "bodies/rigid_mesh.hpp"

namespace softcd::bullet {

/// Identifies a part: its object, its shape (null if its number suffices), the number of the shape among the object's,
/// and the number of the piece of the shape.
using RigidKey = std::tuple<BodyKey, const btCollisionShape*, int, int>;

/// A simple shape of a rigid object, or the piece of it that soft bodies may touch. `Shape` is a RigidMesh or a
/// ConvexCore.
template <class Shape>
struct RigidPart {
  Shape shape;
  const btCollisionObject* object = nullptr;
  btScalar margin = 0;
  BodyId id = {};
  std::uint64_t last_step = 0;  ///< in which a pair required it
};

/// A part that a soft body may touch in a step.
struct NearRigidPart {
  btSoftBody* soft;
  BodyId part;
  const btCollisionObject* object;
  const RigidShape* shape;  ///< valid until the part leaves the scene
  btScalar margin;
};

/// Parts of rigid objects as bodies of the scene. A part stays as long as pairs require it in every step.
template <class Shape>
class RigidParts {
 public:
  using Part = RigidPart<Shape>;

  explicit RigidParts(Scene& scene) : scene_(scene) {}

  /// Begins a step. Call it before require() and want().
  void begin_step() {
    wanted_.clear();
    near_.clear();
    ++step_;
  }
  /// Brings the part up to date at the first call in a step: its triangles, its margin, and its poses at both ends.
  /// `read` reads the triangles into a Shape& and returns whether they have changed.
  template <class Read>
  const Part& require(const RigidKey& key, const btCollisionObject& object, btScalar margin, bool has_edges,
                      const RigidPoses& poses, Read read) {
    const auto [entry, is_new] = parts_.try_emplace(key);
    Part& part = entry->second;
    if (std::exchange(part.last_step, step_) == step_) return part;
    part.object = &object;
    part.margin = margin;
    const bool has_changed = read(part.shape);
    put_in_scene(part, has_edges, is_new, has_changed);
    if (part.shape.place(poses)) scene_.set_positions(part.id, part.shape.x_t0(), part.shape.x_t1());
    return part;
  }
  /// Makes the next query test this soft body, with its id, against the part.
  void want(const Part& part, btSoftBody& soft, BodyId soft_id) {
    wanted_.emplace_back(std::minmax(part.id.value, soft_id.value));
    near_.push_back({&soft, part.id, part.object, &part.shape, part.margin});
  }
  /// Removes parts that no pair required.
  void end_step() {
    std::erase_if(parts_, [this](const auto& entry) {
      const Part& part = entry.second;
      if (part.last_step == step_) return false;
      scene_.remove_body(part.id);
      by_id_.erase(part.id.value);
      return true;
    });
    std::sort(wanted_.begin(), wanted_.end());
  }
  /// Removes all parts.
  void clear() {
    begin_step();
    for (const auto& [key, part] : parts_) {
      if (scene_.has_body(part.id)) scene_.remove_body(part.id);
    }
    parts_.clear();
    by_id_.clear();
  }

  /// Returns null for a key that the last step did not require.
  const Part* find(const RigidKey& key) const {
    const auto known = parts_.find(key);
    return known == parts_.end() ? nullptr : &known->second;
  }
  /// Returns null if no part has the id.
  const Part* find(BodyId id) const {
    const auto known = by_id_.find(id.value);
    return known == by_id_.end() ? nullptr : known->second;
  }
  /// Returns whether this pair of a soft body and a part is to be tested.
  bool wants(BodyId a, BodyId b) const {
    return std::binary_search(wanted_.begin(), wanted_.end(), std::pair(a.value, b.value));
  }
  /// Returns the pairs that are to be tested.
  Span<const NearRigidPart> near_parts() const { return {near_.data(), near_.size()}; }

 private:
  void put_in_scene(Part& part, bool has_edges, bool is_new, bool has_changed) {
    BodySettings settings;
    settings.margin = std::max(0.0F, static_cast<float>(part.margin));
    settings.self_collision = false;
    settings.features = {/*vertex_triangle=*/true, has_edges};
    const BodyDesc desc = {part.shape.triangles(), part.shape.vertex_count(), settings};
    if (is_new) {
      part.id = scene_.add_body(desc);
      by_id_[part.id.value] = &part;
    } else if (has_changed) {
      scene_.update_body(part.id, desc);
    } else {
      scene_.set_settings(part.id, settings);
    }
  }

  Scene& scene_;
  std::uint64_t step_ = 0;
  std::map<RigidKey, Part> parts_;
  std::unordered_map<std::uint32_t, const Part*> by_id_;
  std::vector<NearRigidPart> near_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> wanted_;  ///< ids of `near_`, smaller id first, ascending
};

/// Pieces of rigid meshes as soft bodies of massless nodes that are in no world. Crossing prevention has them in its
/// scene together with the soft bodies: its responses need to know only that the app moves them. Owned by RigidMirror;
/// RigidObstacles calls it.
class RigidProxies {
 public:
  struct Piece {
    RigidPart<RigidMesh> part;
    std::unique_ptr<btSoftBody> body;
  };

  explicit RigidProxies(const NodeEnds& ends) : ends_(ends) {}

  /// Begins a step: removes the pieces that the last one did not require.
  void begin_step();
  /// Reads the piece of a mesh near these boxes, in the mesh's coordinates. Places its nodes for a step of this length.
  /// The first `world_info` stays the body's.
  Piece& require(const RigidKey& key, const btCollisionObject& object, const std::vector<Bounds>& boxes,
                 const RigidPoses& poses, btScalar time_step, btSoftBodyWorldInfo& world_info);
  /// Keeps the piece where the step begins.
  void hold(Piece& piece, const btTransform& start) const;
  void clear();

  /// Returns the proxies of the last step and of this one.
  Span<btSoftBody* const> bodies() const { return {bodies_.data(), bodies_.size()}; }
  /// Returns the object that the proxy represents; null if the body is no proxy.
  const btCollisionObject* object_of(const btSoftBody& body) const;

 private:
  void place(Piece& piece, btScalar time_step) const;

  const NodeEnds& ends_;
  std::uint64_t step_ = 1;
  std::map<RigidKey, Piece> pieces_;
  int last_number_ = 0;
  std::vector<btSoftBody*> bodies_;  ///< of all pieces
};

/// The rigid parts of a world: shape, poses, triangles, and their bodies in the scene or proxies. It reads the part of
/// a mesh that the query's own bodies can reach, so the queries for contacts and for crossings have parts of their own.
/// Owned by WorldMirror.
class RigidMirror {
 public:
  RigidMirror(const NodeEnds& ends, Scene& scene) : meshes(scene), cores(scene), proxies(ends) {}

  RigidParts<RigidMesh> meshes;  ///< for contacts with triangle meshes
  RigidParts<ConvexCore> cores;  ///< for contacts with convex shapes
  RigidProxies proxies;          ///< for crossings of triangle meshes
};

}  // namespace softcd::bullet

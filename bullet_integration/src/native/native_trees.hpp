#pragma once

#include <utility>
#include <vector>

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletSoftBody/btSoftBody.h"
#include "native/pair_gate.hpp"
#include "softcd/core/types.hpp"

/// Keeps Bullet from building and updating bounding volume trees of soft bodies that have no reader.
namespace softcd::bullet {

/// Removes the face tree and its twin for self-collision. Also clears the faces' pointers to leaves, because Bullet
/// writes through these whenever a node is appended.
void remove_face_tree(btSoftBody& body);

/// A flag of btSoftBody::fCollision for which Bullet's prediction builds a face tree, in time quadratic in the faces,
/// and a bit of softcd's that replaces the flag while it is hidden. Nothing in Bullet reads that bit.
struct TreeFlag {
  int flag, hidden;
};
inline constexpr TreeFlag kClassicTreeFlag = {btSoftBody::fCollision::VF_SS, 1 << 30};
inline constexpr TreeFlag kDeformableTreeFlag = {btSoftBody::fCollision::SDF_RD, 1 << 29};

/// Hides the flag. If the faces have changed, removes the face tree, which Bullet's prediction clears. If the app
/// assigns its flags before restore_flag(), the bit is gone and the app's flags stay.
void hide_flag(btSoftBody& body, TreeFlag flag);
/// Restores a hidden flag. In the deformable world, builds the node tree that the prediction would have built with the
/// face tree.
void restore_flag(btSoftBody& body, TreeFlag flag);

/// Hides the flag of the bodies for which the coming prediction would build a face tree.
void hide_tree_flags(Span<btSoftBody* const> bodies, TreeFlag flag);
void restore_tree_flags(Span<btSoftBody* const> bodies, TreeFlag flag);

/// Keeps Bullet's prediction from building face trees and updating node trees. While an object of this class lives,
/// each body has an empty node tree in the deformable world. In classic worlds, it has a tree of one boundless leaf,
/// which is the leaf of every node. Bodies and nodes must not move in memory during that time. If memory for this class
/// runs out, Bullet updates the node trees.
class NodeTreesAtRest {
 public:
  /// `flag` is that of the kind of world.
  NodeTreesAtRest(Span<btSoftBody* const> bodies, TreeFlag flag);
  ~NodeTreesAtRest();
  NodeTreesAtRest(const NodeTreesAtRest&) = delete;
  NodeTreesAtRest& operator=(const NodeTreesAtRest&) = delete;

 private:
  struct Kept {
    btSoftBody* body;
    btDbvtNode* root;
    std::vector<btDbvtNode*> leaves;  ///< one per node in classic worlds
    btDbvtNode boundless;
  };
  static void put_boundless_leaf(Kept& kept);

  Span<btSoftBody* const> bodies_;
  TreeFlag flag_;
  std::vector<Kept> kept_;
};

/// Hides face trees, and their twins for self-collision, until give_back(): Bullet finds empty trees. The bodies must
/// live until then.
class FaceTreesAway {
 public:
  FaceTreesAway() = default;
  explicit FaceTreesAway(Span<btSoftBody* const> bodies) { take(bodies); }
  ~FaceTreesAway() { give_back(); }
  FaceTreesAway(const FaceTreesAway&) = delete;
  FaceTreesAway& operator=(const FaceTreesAway&) = delete;

  /// If memory runs out, removes the trees for good: only ray tests read them, and these build new ones.
  void take(Span<btSoftBody* const> bodies) noexcept;
  void give_back();
  void give_back(const btSoftBody& body);

 private:
  struct Taken {
    btSoftBody* body;
    btDbvtNode* root;
    btDbvntNode* root_with_normals;
  };
  static void give_back(const Taken& taken);

  std::vector<Taken> taken_;
};

/// Keeps Bullet's dispatch from finding vertex-face contacts (VF_DD) in the deformable world until
/// turn_vertex_face_tests_on(). A bit of softcd's replaces btSoftBody::m_softSoftCollision.
void turn_vertex_face_tests_off(Span<btSoftBody* const> bodies);
void turn_vertex_face_tests_on(Span<btSoftBody* const> bodies);

/// Calls refit(body), at least once, for each soft body whose box overlaps a rigid one's: Bullet's soft-rigid test is
/// about to read its trees.
template <class Refit>
void for_each_near_rigid(btOverlappingPairCache& pair_cache, Refit refit) {
  const btSoftBody* last = nullptr;
  for_each_pair_with_rigid(pair_cache, [&](const btBroadphasePair& /*pair*/, btSoftBody& soft) {
    if (std::exchange(last, &soft) != &soft) refit(soft);
  });
}

/// Refits the trees that the deformable soft-rigid test reads: that of the nodes, and with SDF_RDF or SDF_MDF that of
/// the faces.
void refit_deformable_trees(btSoftBody& body);

/// Returns the box that Bullet's prediction in classic worlds gives to a new leaf: around the step's end, enlarged by
/// 1.25 times the body's margin and by the motion of three steps.
btDbvtVolume classic_leaf(const btSoftBody& body, const btSoftBody::Node& node);
btDbvtVolume classic_leaf(const btSoftBody& body, const btSoftBody::Face& face);
/// Returns whether the boxes of ContactRule::ahead contain the body's leaves. They do not if the prediction has moved
/// nodes otherwise than by their velocities, as shape matching does, by most of a margin.
bool leaves_lie_ahead(const btSoftBody& body);

/// Refits node and face tree as Bullet's prediction in classic worlds does. The body has a face tree.
void refit_classic_trees(btSoftBody& body);

/// Gives the body a face tree and its twin for self-collision, as Bullet's prediction does.
void build_face_tree(btSoftBody& body);

/// Refits existing face trees to the nodes' positions, after the deformable world's step. Ray tests read them, and
/// Bullet's prediction refitted them before the solver moved the nodes. (Bullet itself refits them once more in its
/// continuous pass.)
void refit_face_trees(Span<btSoftBody* const> bodies);

/// Removes the tree that Bullet's prediction has built for new or changed faces, so that it updates none in later
/// steps.
///
/// Bullet's construction never ends for a body in several parts: where common edges do not connect all faces, or links
/// all nodes. Such a body gets a tree of softcd's, so that ray tests build none, and its flag VF_SS is hidden from the
/// next prediction. The flag stays if the body has other flags of soft-soft contacts, too: without it Bullet would
/// handle the body by these.
///
/// Call it once a step, after the step's last use of the flag by softcd. Returns whether the body is in several parts:
/// computes it with `topology_changed`, otherwise returns `was_in_parts`, the last call's result.
bool replace_face_tree(btSoftBody& body, bool topology_changed, bool was_in_parts);

}  // namespace softcd::bullet

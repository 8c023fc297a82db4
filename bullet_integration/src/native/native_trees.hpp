#pragma once

#include <vector>

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletSoftBody/btSoftBody.h"
#include "softcd/core/types.hpp"

/// Keeps Bullet from building and updating the bounding volume trees of soft bodies that nobody reads any more.
namespace softcd::bullet {

/// With its twin for self-collision. Its faces name no leaves of it any more: Bullet writes into those that are named
/// whenever a node is appended.
void remove_face_tree(btSoftBody& body);

/// Replaces VF_SS by a bit of ours, which nothing in Bullet reads. Bullet then predicts without a face tree. When
/// the app assigns its flags anew meanwhile, our bit is gone and its flags stand as they are.
void hide_vertex_face_flag(btSoftBody& body);
void restore_vertex_face_flag(btSoftBody& body);

/// Bullet updates no node tree between construction and destruction: each body has a tree of one boundless leaf,
/// which every node takes for its own. Bodies, and their nodes, stay where they are in memory. Where that does not
/// suffice for this class itself, Bullet updates the trees as ever.
class NodeTreesAtRest {
 public:
  explicit NodeTreesAtRest(const btAlignedObjectArray<btSoftBody*>& bodies);
  ~NodeTreesAtRest();
  NodeTreesAtRest(const NodeTreesAtRest&) = delete;
  NodeTreesAtRest& operator=(const NodeTreesAtRest&) = delete;

 private:
  struct Kept {
    btSoftBody* body;
    btDbvtNode* root;
    std::vector<btDbvtNode*> leaves;  ///< one per node
    btDbvtNode boundless;
  };
  std::vector<Kept> kept_;
};

/// Bullet sees the bodies' trees (m_fdbvt of faces, m_ndbvt of nodes) empty between construction and destruction: it
/// finds nothing in them, and the deformable world does not refit them. Where memory does not suffice it sees them.
class TreesOutOfSight {
 public:
  TreesOutOfSight(const btAlignedObjectArray<btSoftBody*>& bodies, btDbvt btSoftBody::*tree);
  ~TreesOutOfSight();
  TreesOutOfSight(const TreesOutOfSight&) = delete;
  TreesOutOfSight& operator=(const TreesOutOfSight&) = delete;

  bool succeeded() const { return succeeded_; }

 private:
  struct Kept {
    btDbvt* tree;
    btDbvtNode* root;
  };
  std::vector<Kept> kept_;
  bool succeeded_ = false;
};

/// The same of SDF_RD: the deformable world's prediction then builds no face tree. Where the flag was hidden, restoring
/// it builds the node tree that the prediction would have built.
void hide_rigid_deformable_flag(btSoftBody& body);
void restore_rigid_deformable_flag(btSoftBody& body);

/// Face trees that Bullet sees empty, with their twins for self-collision, for as long as it takes until they are given
/// back. The bodies are there until then.
class FaceTreesAway {
 public:
  /// Where memory does not suffice the trees are gone for good.
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

/// The deformable world's prediction builds no face tree, quadratic in the faces, between construction and destruction.
/// The node trees that it would have built come with the destruction.
class FaceTreesUnbuilt {
 public:
  /// The array stays as it is.
  explicit FaceTreesUnbuilt(const btAlignedObjectArray<btSoftBody*>& bodies);
  ~FaceTreesUnbuilt();
  FaceTreesUnbuilt(const FaceTreesUnbuilt&) = delete;
  FaceTreesUnbuilt& operator=(const FaceTreesUnbuilt&) = delete;

 private:
  const btAlignedObjectArray<btSoftBody*>& bodies_;
};

/// Bullet's dispatch finds no vertex-face contacts (VF_DD) in the deformable world between construction and
/// destruction: a bit of ours stands for btSoftBody::m_softSoftCollision.
class VertexFaceTestsOff {
 public:
  /// The array stays as it is.
  explicit VertexFaceTestsOff(const btAlignedObjectArray<btSoftBody*>& bodies);
  ~VertexFaceTestsOff();
  VertexFaceTestsOff(const VertexFaceTestsOff&) = delete;
  VertexFaceTestsOff& operator=(const VertexFaceTestsOff&) = delete;

 private:
  const btAlignedObjectArray<btSoftBody*>& bodies_;
};

/// Calls refit(body) for the soft bodies whose boxes overlap a rigid one's, at least once each: Bullet's soft-rigid
/// test is about to read their trees.
template <class Refit>
void for_each_near_rigid(btOverlappingPairCache& pair_cache, Refit refit) {
  const btBroadphasePair* pairs = pair_cache.getOverlappingPairArrayPtr();
  const btSoftBody* last = nullptr;
  for (int i = 0; i < pair_cache.getNumOverlappingPairs(); ++i) {
    auto* a = btSoftBody::upcast(static_cast<btCollisionObject*>(pairs[i].m_pProxy0->m_clientObject));
    auto* b = btSoftBody::upcast(static_cast<btCollisionObject*>(pairs[i].m_pProxy1->m_clientObject));
    if ((a == nullptr) == (b == nullptr)) continue;
    btSoftBody* soft = a != nullptr ? a : b;
    if (soft == last) continue;
    refit(*soft);
    last = soft;
  }
}

/// Brings the trees up to date that the deformable soft-rigid test reads: of nodes, and with SDF_RDF or SDF_MDF of
/// faces.
void refit_deformable_trees(btSoftBody& body);

/// The boxes that Bullet's prediction in classic worlds gives to leaves of its trees when it makes them anew: around
/// the step's end, with 1.25 times the body's margin, and on along the motion of three steps.
btDbvtVolume classic_leaf(const btSoftBody& body, const btSoftBody::Node& node);
btDbvtVolume classic_leaf(const btSoftBody& body, const btSoftBody::Face& face);

/// As Bullet's prediction in classic worlds does. The body has a face tree.
void refit_classic_trees(btSoftBody& body);

/// Bullet finds vertex-face contacts between construction and destruction: the bodies have face trees.
class NativeTreesBuilt {
 public:
  /// Calls refit(body) for all of them.
  NativeTreesBuilt(Span<btSoftBody* const> bodies, void (*refit)(btSoftBody&));
  ~NativeTreesBuilt();
  NativeTreesBuilt(const NativeTreesBuilt&) = delete;
  NativeTreesBuilt& operator=(const NativeTreesBuilt&) = delete;

 private:
  Span<btSoftBody* const> bodies_;
};

/// Brings the face trees that there are to where the nodes are. After the deformable world's step: ray tests read them,
/// and Bullet's prediction refitted them before it was known where the nodes go. (Bullet itself refits them once more
/// in its continuous pass.)
void refit_face_trees(const btAlignedObjectArray<btSoftBody*>& bodies);

/// Decides, step by step, whether a body's face tree has a reader. Bullet builds one in its prediction after a
/// change of topology, while VF_SS is visible, and refits it in every step from then on; btSoftBody::rayTest builds
/// one when there is none.
class FaceTreeWatch {
 public:
  /// To be called once a step, after Bullet's prediction. Removes a tree that the prediction built. A tree that
  /// comes back with the same topology belongs to ray tests and is left to Bullet.
  void drop_unread_tree(btSoftBody& body, bool topology_changed);

 private:
  bool dropped_ = false;
  bool has_reader_ = false;
};

}  // namespace softcd::bullet

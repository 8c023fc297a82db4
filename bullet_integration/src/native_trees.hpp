#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"

/// Keeps Bullet from building and updating the bounding volume trees of soft bodies that nobody reads any more.
namespace softcd::bullet {

/// Replaces VF_SS by a bit of ours, which nothing in Bullet reads. Bullet then predicts without a face tree. When
/// the app assigns its flags anew meanwhile, our bit is gone and its flags stand as they are.
void hide_vertex_face_flag(btSoftBody& body);
void restore_vertex_face_flag(btSoftBody& body);

/// Bullet updates no node tree between construction and destruction: each body has a tree of one boundless leaf,
/// which every node takes for its own. Bodies, and their nodes, stay where they are in memory.
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

/// Bullet sees empty face trees between construction and destruction, so its own vertex-face test finds nothing.
/// Only ray tests ever build such trees here; they stay theirs.
class FaceTreesOutOfSight {
 public:
  explicit FaceTreesOutOfSight(const btAlignedObjectArray<btSoftBody*>& bodies);
  ~FaceTreesOutOfSight();
  FaceTreesOutOfSight(const FaceTreesOutOfSight&) = delete;
  FaceTreesOutOfSight& operator=(const FaceTreesOutOfSight&) = delete;

 private:
  struct Kept {
    btSoftBody* body;
    btDbvtNode* root;
  };
  std::vector<Kept> kept_;
};

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

#include "native_trees.hpp"

namespace softcd::bullet {
namespace {

// Bullet's own flags end at bit 10.
constexpr int kHiddenVertexFace = 1 << 30;

}  // namespace

void hide_vertex_face_flag(btSoftBody& body) {
  int& flags = body.m_cfg.collisions;
  if (flags & btSoftBody::fCollision::VF_SS) flags = (flags & ~btSoftBody::fCollision::VF_SS) | kHiddenVertexFace;
}

void restore_vertex_face_flag(btSoftBody& body) {
  int& flags = body.m_cfg.collisions;
  if (flags & kHiddenVertexFace) flags = (flags & ~kHiddenVertexFace) | btSoftBody::fCollision::VF_SS;
}

NodeTreesAtRest::NodeTreesAtRest(const btAlignedObjectArray<btSoftBody*>& bodies)
    : kept_(static_cast<std::size_t>(bodies.size())) {
  const btVector3 everything(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
  for (int i = 0; i < bodies.size(); ++i) {
    Kept& kept = kept_[static_cast<std::size_t>(i)];
    kept.body = bodies[i];
    kept.root = kept.body->m_ndbvt.m_root;
    kept.boundless.volume = btDbvtVolume::FromMM(-everything, everything);
    kept.boundless.parent = nullptr;
    kept.boundless.childs[0] = nullptr;
    kept.boundless.childs[1] = nullptr;
    // The leaf is a whole tree, not a loose node: a position that is not finite is in no volume, and Bullet then
    // takes the leaf out of the tree and puts it back.
    kept.body->m_ndbvt.m_root = &kept.boundless;
    btSoftBody::tNodeArray& nodes = kept.body->m_nodes;
    kept.leaves.reserve(static_cast<std::size_t>(nodes.size()));
    for (int n = 0; n < nodes.size(); ++n) {
      kept.leaves.push_back(nodes[n].m_leaf);
      nodes[n].m_leaf = &kept.boundless;
    }
  }
}

NodeTreesAtRest::~NodeTreesAtRest() {
  for (Kept& kept : kept_) {
    kept.body->m_ndbvt.m_root = kept.root;
    int n = 0;
    for (btDbvtNode* leaf : kept.leaves) kept.body->m_nodes[n++].m_leaf = leaf;
  }
}

TreesOutOfSight::TreesOutOfSight(const btAlignedObjectArray<btSoftBody*>& bodies, btDbvt btSoftBody::*tree) {
  for (int i = 0; i < bodies.size(); ++i) {
    btDbvt& kept = bodies[i]->*tree;
    kept_.push_back({&kept, kept.m_root});
    kept.m_root = nullptr;
  }
}

TreesOutOfSight::~TreesOutOfSight() {
  for (const Kept& kept : kept_) kept.tree->m_root = kept.root;
}

FaceTreesUnbuilt::FaceTreesUnbuilt(const btAlignedObjectArray<btSoftBody*>& bodies) {
  for (int i = 0; i < bodies.size(); ++i) {
    int& flags = bodies[i]->m_cfg.collisions;
    if (!bodies[i]->m_bUpdateRtCst || (flags & btSoftBody::fCollision::SDF_RD) == 0) continue;
    flags &= ~btSoftBody::fCollision::SDF_RD;
    bodies_.push_back(bodies[i]);
  }
}

FaceTreesUnbuilt::~FaceTreesUnbuilt() {
  for (btSoftBody* body : bodies_) body->m_cfg.collisions |= btSoftBody::fCollision::SDF_RD;
}

void refit_deformable_trees(btSoftBody& body) {
  body.updateNodeTree(/*use_velocity=*/true, /*margin=*/true);
  const int with_faces = btSoftBody::fCollision::SDF_RDF | btSoftBody::fCollision::SDF_MDF;
  if ((body.m_cfg.collisions & with_faces) == 0 || !body.m_fdbvt.empty()) return;
  for (int i = 0; i < body.m_faces.size(); ++i) {
    btSoftBody::Face& face = body.m_faces[i];
    const btVector3* const points[] = {&face.m_n[0]->m_x, &face.m_n[1]->m_x, &face.m_n[2]->m_x};
    face.m_leaf = body.m_fdbvt.insert(btDbvtVolume::FromPoints(const_cast<const btVector3**>(points), 3), &face);
  }
  // Its twin with normals serves only Bullet's self-collision, and is of faces that may be gone.
  delete body.m_fdbvnt;
  body.m_fdbvnt = nullptr;
  body.updateFaceTree(/*use_velocity=*/true, /*margin=*/true);
}

void refit_face_trees(const btAlignedObjectArray<btSoftBody*>& bodies) {
  for (int i = 0; i < bodies.size(); ++i) {
    if (!bodies[i]->isActive() || bodies[i]->m_fdbvt.empty()) continue;
    bodies[i]->updateFaceTree(/*use_velocity=*/false, /*margin=*/false);
  }
}

void FaceTreeWatch::drop_unread_tree(btSoftBody& body, bool topology_changed) {
  if (body.m_fdbvt.empty()) {
    has_reader_ = false;
    return;
  }
  if (has_reader_) return;
  if (dropped_ && !topology_changed) {
    has_reader_ = true;
    return;
  }
  body.m_fdbvt.clear();
  dropped_ = !topology_changed;
}

}  // namespace softcd::bullet

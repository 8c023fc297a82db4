#include "native/native_trees.hpp"

#include <algorithm>
#include <functional>
#include <new>
#include <tuple>
#include <utility>

#include "native/arrays.hpp"
#include "native/tree_shape.hpp"
#include "softcd/bullet/world_detection.hpp"
#include "softcd/stages/boxes_ahead.hpp"

namespace softcd::bullet {
namespace {

using Flags = btSoftBody::fCollision;

// Bullet's own flags end at bit 10.
constexpr int kHiddenSoftSoftCollision = 1 << 28;
/// Factor of a body's margin by which Bullet enlarges the leaves of its trees in classic worlds.
constexpr btScalar kLeafMargin = btScalar(1.25);

void replace_bits(int& flags, int bits, int by) {
  if ((flags & bits) != 0) flags = (flags & ~bits) | by;
}

btDbvtVolume volume_of(const btSoftBody::Face& face) {
  const btVector3 points[] = {face.m_n[0]->m_x, face.m_n[1]->m_x, face.m_n[2]->m_x};
  return btDbvtVolume::FromPoints(points, 3);
}

btDbvtVolume volume_of(const btSoftBody::Node& node) {
  return btDbvtVolume::FromCR(node.m_x, 0);
}

/// Nodes at a common link are neighbours.
NeighbourLists neighbours_of_nodes(const btSoftBody& body) {
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(static_cast<std::size_t>(body.m_links.size()));
  const auto index_of = [&](const btSoftBody::Node* node) { return static_cast<int>(node - &body.m_nodes[0]); };
  for (const btSoftBody::Link& link : span_of(body.m_links)) {
    pairs.emplace_back(index_of(link.m_n[0]), index_of(link.m_n[1]));
  }
  return {body.m_nodes.size(), pairs};
}

/// Faces at a common edge are neighbours. If an edge has more than two faces, only consecutive ones are.
NeighbourLists neighbours_of_faces(const btSoftBody& body) {
  struct Side {
    const btSoftBody::Node* ends[2];
    int face;
  };
  std::vector<Side> sides;
  for (int i = 0; i < body.m_faces.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      const auto [first, second] =
          std::minmax(body.m_faces[i].m_n[corner], body.m_faces[i].m_n[(corner + 1) % 3], std::less<>());
      sides.push_back({{first, second}, i});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.ends[0], a.ends[1], a.face) < std::tie(b.ends[0], b.ends[1], b.face);
  });
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 1; i < sides.size(); ++i) {
    if (std::equal(sides[i].ends, sides[i].ends + 2, sides[i - 1].ends)) {
      pairs.emplace_back(sides[i - 1].face, sides[i].face);
    }
  }
  NeighbourLists lists(body.m_faces.size(), pairs);
  lists.sort();
  return lists;
}

/// Whether btSoftBody::initializeFaceTree ends. It joins neighbours until one tree is left. Without memory to find out,
/// the answer is yes, as for most bodies.
bool face_tree_ends(const btSoftBody& body) {
  try {
    return is_connected(neighbours_of_nodes(body)) && is_connected(neighbours_of_faces(body));
  } catch (const std::bad_alloc&) {
    return true;
  }
}

/// Replaces the tree by one with a leaf for each of `things`.
template <class Things>
void build_tree(btDbvt& tree, Things& things, const TreeShape& shape) {
  std::vector<btDbvtNode*> nodes(static_cast<std::size_t>(things.size()) + shape.size());
  if (nodes.empty()) return;
  tree.clear();
  std::size_t added = 0;
  const auto add = [&] {
    auto* node = new (btAlignedAlloc(sizeof(btDbvtNode), 16)) btDbvtNode;
    node->parent = nullptr;
    node->childs[1] = nullptr;
    return nodes[added++] = node;
  };
  for (auto& thing : span_of(things)) {
    thing.m_leaf = add();
    thing.m_leaf->volume = volume_of(thing);
    thing.m_leaf->data = &thing;
  }
  for (const auto& children : shape) {
    btDbvtNode* node = add();
    node->childs[0] = nodes[static_cast<std::size_t>(children.first)];
    node->childs[1] = nodes[static_cast<std::size_t>(children.second)];
    for (btDbvtNode* child : node->childs) child->parent = node;
    Merge(node->childs[0]->volume, node->childs[1]->volume, node->volume);
  }
  tree.m_root = nodes.back();
  tree.m_leaves = things.size();
}

/// Gives the body the node tree that Bullet's prediction builds together with a face tree. If memory runs out, the tree
/// stays as it is.
void rebuild_node_tree(btSoftBody& body) {
  try {
    build_tree(body.m_ndbvt, body.m_nodes, tree_shape(neighbours_of_nodes(body)));
  } catch (const std::bad_alloc&) {
    return;
  }
}

/// Adds a face tree to a body without one. If memory runs out, its shape differs from Bullet's.
void add_face_tree(btSoftBody& body) {
  try {
    build_tree(body.m_fdbvt, body.m_faces, tree_shape(neighbours_of_faces(body)));
  } catch (const std::bad_alloc&) {
    for (btSoftBody::Face& face : span_of(body.m_faces)) {
      face.m_leaf = body.m_fdbvt.insert(volume_of(face), &face);
    }
  }
}

/// Returns the twin of a face tree, which has space for normals, as Bullet makes it.
btDbvntNode* copy_with_normals(const btDbvtNode* node) {
  if (node == nullptr) return nullptr;
  auto* copy = new btDbvntNode(node);
  if (node->isinternal()) {
    for (int i = 0; i < 2; ++i) copy->childs[i] = copy_with_normals(node->childs[i]);
  }
  return copy;
}

/// Sleeping bodies have no prediction, and do not move.
btDbvtVolume predicted_leaf(const btSoftBody& body, btDbvtVolume box, const btVector3& velocity) {
  const btScalar growth = body.getCollisionShape()->getMargin() * kLeafMargin;
  box.Expand(btVector3(growth, growth, growth));
  if (body.isActive()) box.SignedExpand(velocity * body.m_sst.velmrg);
  return box;
}

}  // namespace

void remove_face_tree(btSoftBody& body) {
  body.m_fdbvt.clear();
  for (btSoftBody::Face& face : span_of(body.m_faces)) face.m_leaf = nullptr;
  delete body.m_fdbvnt;
  body.m_fdbvnt = nullptr;
}

void build_face_tree(btSoftBody& body) {
  add_face_tree(body);
  delete body.m_fdbvnt;
  body.m_fdbvnt = copy_with_normals(body.m_fdbvt.m_root);
}

void hide_flag(btSoftBody& body, TreeFlag flag) {
  if (body.m_bUpdateRtCst) remove_face_tree(body);
  replace_bits(body.m_cfg.collisions, flag.flag, flag.hidden);
}

void restore_flag(btSoftBody& body, TreeFlag flag) {
  const bool is_hidden = (body.m_cfg.collisions & flag.hidden) != 0;
  if (is_hidden && flag.flag == kDeformableTreeFlag.flag) rebuild_node_tree(body);
  replace_bits(body.m_cfg.collisions, flag.hidden, flag.flag);
}

void hide_tree_flags(Span<btSoftBody* const> bodies, TreeFlag flag) {
  for (btSoftBody* body : bodies) {
    if (body->m_bUpdateRtCst) hide_flag(*body, flag);
  }
}

void restore_tree_flags(Span<btSoftBody* const> bodies, TreeFlag flag) {
  for (btSoftBody* body : bodies) restore_flag(*body, flag);
}

NodeTreesAtRest::NodeTreesAtRest(Span<btSoftBody* const> bodies, TreeFlag flag) : bodies_(bodies), flag_(flag) {
  hide_tree_flags(bodies, flag);
  const bool is_classic = flag.flag == kClassicTreeFlag.flag;
  try {
    kept_.resize(bodies.size());
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      kept_[i].body = bodies[i];
      const btSoftBody::tNodeArray& nodes = bodies[i]->m_nodes;
      if (is_classic) kept_[i].leaves.reserve(static_cast<std::size_t>(nodes.size()));
      for (int n = 0; is_classic && n < nodes.size(); ++n) kept_[i].leaves.push_back(nodes[n].m_leaf);
    }
  } catch (const std::bad_alloc&) {
    kept_.clear();
  }
  for (Kept& kept : kept_) {
    kept.root = std::exchange(kept.body->m_ndbvt.m_root, nullptr);
    if (is_classic) put_boundless_leaf(kept);
  }
}

/// The leaf is a whole tree, not a loose node. A position that is not finite lies in no volume, so Bullet takes its
/// leaf out of the tree and puts it back.
void NodeTreesAtRest::put_boundless_leaf(Kept& kept) {
  const btVector3 everything(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
  kept.boundless.volume = btDbvtVolume::FromMM(-everything, everything);
  kept.boundless.parent = nullptr;
  kept.boundless.childs[0] = nullptr;
  kept.boundless.childs[1] = nullptr;
  kept.body->m_ndbvt.m_root = &kept.boundless;
  for (btSoftBody::Node& node : span_of(kept.body->m_nodes)) node.m_leaf = &kept.boundless;
}

NodeTreesAtRest::~NodeTreesAtRest() {
  for (Kept& kept : kept_) {
    kept.body->m_ndbvt.m_root = kept.root;
    int n = 0;
    for (btDbvtNode* leaf : kept.leaves) kept.body->m_nodes[n++].m_leaf = leaf;
  }
  restore_tree_flags(bodies_, flag_);
}

void FaceTreesAway::take(Span<btSoftBody* const> bodies) noexcept {
  const auto has_tree = [](const btSoftBody* body) {
    return body->m_fdbvt.m_root != nullptr || body->m_fdbvnt != nullptr;
  };
  try {
    taken_.reserve(static_cast<std::size_t>(std::count_if(bodies.begin(), bodies.end(), has_tree)));
  } catch (const std::bad_alloc&) {
    for (btSoftBody* body : bodies) remove_face_tree(*body);
    return;
  }
  for (btSoftBody* body : bodies) {
    if (!has_tree(body)) continue;
    taken_.push_back({body, std::exchange(body->m_fdbvt.m_root, nullptr), std::exchange(body->m_fdbvnt, nullptr)});
  }
}

void FaceTreesAway::give_back() {
  for (const Taken& taken : taken_) give_back(taken);
  taken_.clear();
}

void FaceTreesAway::give_back(const btSoftBody& body) {
  const auto taken = std::find_if(taken_.begin(), taken_.end(), [&](const Taken& each) { return each.body == &body; });
  if (taken == taken_.end()) return;
  give_back(*taken);
  taken_.erase(taken);
}

/// If an app has cast a ray at the body since take(), the body has a new tree, and its faces point to that tree's
/// leaves. The new tree then stays.
void FaceTreesAway::give_back(const Taken& taken) {
  btDbvt old;
  (taken.body->m_fdbvt.m_root == nullptr ? taken.body->m_fdbvt : old).m_root = taken.root;
  if (taken.body->m_fdbvnt == nullptr) {
    taken.body->m_fdbvnt = taken.root_with_normals;
  } else {
    delete taken.root_with_normals;
  }
}

void turn_vertex_face_tests_off(Span<btSoftBody* const> bodies) {
  for (btSoftBody* body : bodies) {
    if (std::exchange(body->m_softSoftCollision, false)) body->m_cfg.collisions |= kHiddenSoftSoftCollision;
  }
}

void turn_vertex_face_tests_on(Span<btSoftBody* const> bodies) {
  for (btSoftBody* body : bodies) {
    if ((body->m_cfg.collisions & kHiddenSoftSoftCollision) != 0) body->m_softSoftCollision = true;
    replace_bits(body->m_cfg.collisions, kHiddenSoftSoftCollision, 0);
  }
}

void refit_deformable_trees(btSoftBody& body) {
  body.updateNodeTree(/*use_velocity=*/true, /*margin=*/true);
  const int with_faces = Flags::SDF_RDF | Flags::SDF_MDF;
  if ((body.m_cfg.collisions & with_faces) == 0 || !body.m_fdbvt.empty()) return;
  add_face_tree(body);
  // The twin with normals serves only Bullet's self-collision, and may be of faces that are gone.
  delete body.m_fdbvnt;
  body.m_fdbvnt = nullptr;
  body.updateFaceTree(/*use_velocity=*/true, /*margin=*/true);
}

btDbvtVolume classic_leaf(const btSoftBody& body, const btSoftBody::Node& node) {
  return predicted_leaf(body, btDbvtVolume::FromCR(node.m_x, 0), node.m_v);
}

btDbvtVolume classic_leaf(const btSoftBody& body, const btSoftBody::Face& face) {
  return predicted_leaf(body, volume_of(face), (face.m_n[0]->m_v + face.m_n[1]->m_v + face.m_n[2]->m_v) / 3);
}

bool leaves_lie_ahead(const btSoftBody& body) {
  if (!body.isActive()) return true;
  constexpr btScalar kRounding = 16 * SIMD_EPSILON;
  const btScalar slack = (btScalar(kAheadMargins) - kLeafMargin) * body.getCollisionShape()->getMargin();
  const Span<const btSoftBody::Node> nodes = span_of(body.m_nodes);
  return std::all_of(nodes.begin(), nodes.end(), [&](const btSoftBody::Node& node) {
    bool lies_ahead = true;
    for (int axis = 0; axis < 3; ++axis) {
      const btScalar end = node.m_x[axis];
      const btScalar start = node.m_q[axis];
      const btScalar difference = body.m_sst.velmrg * node.m_v[axis] - btScalar(kAheadMotion) * (end - start);
      lies_ahead &= btFabs(difference) + kRounding * (btFabs(end) + btFabs(start)) <= slack;
    }
    return lies_ahead;
  });
}

void refit_classic_trees(btSoftBody& body) {
  const auto refit = [&](btDbvt& tree, auto& things) {
    for (auto& thing : span_of(things)) {
      btDbvtVolume box = classic_leaf(body, thing);
      tree.update(thing.m_leaf, box);
    }
  };
  refit(body.m_ndbvt, body.m_nodes);
  refit(body.m_fdbvt, body.m_faces);
}

void refit_face_trees(Span<btSoftBody* const> bodies) {
  for (btSoftBody* body : bodies) {
    // If faces have changed, the next prediction discards the tree.
    if (!body->isActive() || body->m_fdbvt.empty() || body->m_bUpdateRtCst) continue;
    body->updateFaceTree(/*use_velocity=*/false, /*margin=*/false);
  }
}

bool replace_face_tree(btSoftBody& body, bool topology_changed, bool was_in_parts) {
  if (topology_changed) remove_face_tree(body);
  const bool is_in_parts = topology_changed ? !face_tree_ends(body) : was_in_parts;
  if (!is_in_parts || (body.m_cfg.collisions & kClassicTreeFlag.flag) == 0) return is_in_parts;
  if (body.m_fdbvt.empty()) add_face_tree(body);
  if ((body.m_cfg.collisions & Flags::SVSmask) == kClassicTreeFlag.flag) hide_flag(body, kClassicTreeFlag);
  return is_in_parts;
}

}  // namespace softcd::bullet

// Builds one only for bodies for which Bullet itself would: with VF_SS in classic worlds, with SDF_RD in the deformable
// one.
void softcd::bullet::give_face_tree(btSoftBody& body) {
  const bool is_wanted = (body.m_cfg.collisions & (Flags::VF_SS | Flags::SDF_RD)) != 0;
  if (!is_wanted || body.m_bUpdateRtCst) return;
  if (body.m_fdbvt.empty()) {
    build_face_tree(body);
  } else if (body.m_fdbvnt == nullptr) {
    body.m_fdbvnt = copy_with_normals(body.m_fdbvt.m_root);
  }
}

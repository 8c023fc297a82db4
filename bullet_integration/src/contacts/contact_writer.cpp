#include "contacts/contact_writer.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "bodies/inverse_mass.hpp"
#include "bodies/vectors.hpp"
#include "contacts/joint_margin.hpp"
#include "contacts/tangles.hpp"
#include "native/native_trees.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::bullet {
namespace {

btScalar margin_sum(const btSoftBody& a, const btSoftBody& b) {
  return margin_of(a) + margin_of(b);
}

// Bullet's margin for a contact of `node`: both bodies' margins, plus a multiple of the node's motion in a discrete
// detection. Within a body the motion relative to the face matters, and Bullet has no rule, so nothing is added.
btScalar contact_margin(const btSoftBody& node_body, const btSoftBody& face_body, const btSoftBody::Node& node,
                        Detection detection) {
  const btScalar margins = margin_sum(node_body, face_body);
  if (detection == Detection::ccd || &node_body == &face_body) return margins;
  return margins + (node.m_x - node.m_q).length() * btScalar(kBulletMotionMargin);
}

// Returns the face's inverse mass at the contact as Bullet's solver computes it: 0 if one of its nodes is immovable. A
// disabled body counts as immovable: only contacts would move it, and no spring would move it back.
btScalar inverse_mass_of(const btSoftBody& body, const btSoftBody::Face& face, const btVector3& weights) {
  if (is_disabled(body)) return 0;
  btScalar inverse_mass = 0;
  for (int i = 0; i < 3; ++i) {
    if (face.m_n[i]->m_im <= 0) return 0;
    inverse_mass += face.m_n[i]->m_im * weights[i];
  }
  return inverse_mass;
}

// An edge-edge contact in the form of Bullet's vertex-face contacts: the nodes of one edge, and a face at the other
// edge. The weights are the contact's at that edge's nodes and 0 at the face's third node. The nodes are those of the
// edge that is easier to move, because Bullet's deformable response uses no other mass than the node's.
struct EdgeOnFace {
  btSoftBody* node_body;
  btSoftBody* face_body;
  btSoftBody::Node* nodes[2];
  btScalar node_weights[2];
  btScalar further[2];  ///< how much farther along the normal the nodes lie than the contact's point
  btSoftBody::Face* face;
  btVector3 weights;
  btVector3 normal;  ///< towards the nodes' edge
};

EdgeOnFace edge_on_face(const MemberContact& found) {
  const Contact& contact = found.contact;
  const float(&w)[4] = contact.weights;
  btSoftBody::Node* const nodes[4] = {&found.node(0), &found.node(1), &found.node(2), &found.node(3)};
  const auto inverse_mass_at = [&](int first) {
    if (is_disabled(first == 0 ? *found.a.body : *found.b.body)) return btScalar(0);
    return btScalar(w[first]) * nodes[first]->m_im + btScalar(w[first + 1]) * nodes[first + 1]->m_im;
  };
  const bool is_swapped = inverse_mass_at(0) < inverse_mass_at(2);
  const WorldMirror::Member& node_side = is_swapped ? found.b : found.a;
  const WorldMirror::Member& face_side = is_swapped ? found.a : found.b;
  const int first_node = is_swapped ? 2 : 0;
  const int first_corner = is_swapped ? 0 : 2;

  EdgeOnFace result;
  result.node_body = node_side.body;
  result.face_body = face_side.body;
  result.normal = is_swapped ? -to_bullet(contact.normal) : to_bullet(contact.normal);
  const std::uint32_t edge = is_swapped ? contact.feature_a : contact.feature_b;
  result.face = &face_side.face_at_edge(edge, contact.vertices + first_corner);
  result.weights.setZero();
  for (int i = first_corner; i < first_corner + 2; ++i) {
    int corner = 0;  // the first, as the face of a link of two nodes has one of them twice
    while (result.face->m_n[corner] != nodes[i]) ++corner;
    result.weights[corner] = btScalar(w[i]);
  }
  btVector3 point(0, 0, 0);
  for (int i = 0; i < 2; ++i) {
    result.nodes[i] = nodes[first_node + i];
    result.node_weights[i] = btScalar(w[first_node + i]);
    point += result.nodes[i]->m_x * result.node_weights[i];
  }
  for (int i = 0; i < 2; ++i) result.further[i] = result.normal.dot(result.nodes[i]->m_x - point);
  return result;
}

// Returns 0 if one of the edge's nodes is immovable: Bullet's solver would move that one too.
btScalar inverse_mass_of_edge(const EdgeOnFace& edge) {
  if (is_disabled(*edge.face_body)) return 0;
  btScalar inverse_mass = 0;
  for (int corner = 0; corner < 3; ++corner) {
    if (!(edge.weights[corner] > 0)) continue;
    if (edge.face->m_n[corner]->m_im <= 0) return 0;
    inverse_mass += edge.weights[corner] * edge.face->m_n[corner]->m_im;
  }
  return inverse_mass;
}

/// Returns whether the velocities of all nodes are finite. Bullet's deformable response would spread other values, even
/// from a node with weight 0.
template <int kCount>
bool have_velocities(btSoftBody::Node* const (&nodes)[kCount]) {
  return std::all_of(std::begin(nodes), std::end(nodes),
                     [](const auto* each) { return std::isfinite(each->m_v.length2()); });
}

btSoftBody::DeformableFaceNodeContact deformable_contact(btSoftBody& node_body, btSoftBody::Node& node,
                                                         btSoftBody& face_body, btSoftBody::Face& face) {
  btSoftBody::DeformableFaceNodeContact result;
  result.m_node = &node;
  result.m_face = &face;
  result.m_friction = node_body.m_cfg.kDF * face_body.m_cfg.kDF;
  result.m_colObj = &face_body;
  // Bullet reads none of these.
  result.m_weights.setZero();
  result.m_imf = 0;
  result.m_c0 = 0;
  return result;
}

// Returns Bullet's choice of a normal: the face's, on the node's side unless the face bounds a volume.
btVector3 deformable_normal(const MemberContact& found, const btSoftBody::Node& node, const btSoftBody::Face& face) {
  const bool has_normal = face.m_normal.length2() > btScalar(0.5);
  if (!has_normal) return to_bullet(found.contact.normal);
  const bool bounds_volume = found.b.body->m_tetras.size() > 0;
  return !bounds_volume && face.m_normal.dot(node.m_x - face.m_n[2]->m_x) < 0 ? -face.m_normal : face.m_normal;
}

/// Returns the box of a leaf of Bullet's trees: around the predicted motion of nodes, enlarged by their body's margin.
template <int kCount>
btDbvtVolume box_of(const btSoftBody& body, const btSoftBody::Node* const (&nodes)[kCount]) {
  btVector3 ends[2 * kCount];
  for (int i = 0; i < kCount; ++i) {
    ends[i] = nodes[i]->m_x;
    ends[kCount + i] = nodes[i]->m_q;
  }
  const btScalar margin = margin_of(body);
  btDbvtVolume box = btDbvtVolume::FromPoints(ends, 2 * kCount);
  box.Expand(btVector3(margin, margin, margin));
  return box;
}

btDbvtVolume box_of(const btSoftBody& body, const btSoftBody::Face& face) {
  const btSoftBody::Node* const nodes[] = {face.m_n[0], face.m_n[1], face.m_n[2]};
  return box_of(body, nodes);
}

btDbvtVolume box_of(const btSoftBody& body, const btSoftBody::Node& node) {
  const btSoftBody::Node* const nodes[] = {&node};
  return box_of(body, nodes);
}

/// Follows Bullet's rule within a body (CollideFF_DD): a node touches a face if one of the faces around the node is
/// near it and shares no node with it. Nodes without faces do not touch their own body's faces.
bool has_face_near(const WorldMirror::Member& member, std::uint32_t node, std::uint32_t face) {
  const std::vector<Triangle>& triangles = member.mesh.triangles;
  const btDbvtVolume box = box_of(*member.body, member.face(face));
  const Span<const FaceAtNode> faces = member.mesh.faces_at(node);
  return std::any_of(faces.begin(), faces.end(), [&](const FaceAtNode& at_node) {
    return !share_vertex(triangles[at_node.face], triangles[face]) &&
           Intersect(box_of(*member.body, member.face(at_node.face)), box);
  });
}

/// Returns whether the node is beside its body's face: more than twice as far from it as from its plane. Bullet's
/// trees find no contacts within a flat part of a surface, whose normals lie in a cone. ContactRule::slab does where
/// faces are finer than the margins, and such contacts would crumple the surface.
bool is_beside_face(const MemberContact& found) {
  return distance_from_face(found) > 2 * double(found.contact.distance);
}

/// Returns whether Bullet's trees would find the pair. ContactRule::slab reaches farther beyond the edges of a face
/// that is small compared with the margins, and would push away nodes that are beside the face.
bool are_near_for_bullet(const MemberContact& found) {
  if (&found.a == &found.b) {
    const std::uint32_t face = found.contact.feature_b;
    const bool is_near = has_face_near(found.a, found.contact.feature_a, face);
    return is_near && !(is_finer_than_margins(found.b, face) && is_beside_face(found));
  }
  return Intersect(box_of(*found.a.body, found.node(0)), box_of(*found.b.body, found.face()));
}

/// Returns whether Bullet's trees would find the pair. Bullet enlarges the margin by the node's motion in any
/// direction, but finds pairs by its trees, whose boxes reach ahead along the motion. Without this test, Bullet's
/// solver would throw apart features that move together. With fewer pairs, it would stop falling bodies late, and these
/// would bounce.
bool are_in_boxes_of_classic_trees(const MemberContact& found) {
  return Intersect(classic_leaf(*found.a.body, found.node(0)), classic_leaf(*found.b.body, found.face()));
}

/// How far beyond an edge of a face a node still passes through the face, as a share of the face's height above that
/// edge. So nodes do not slip through edges and corners by rounding.
constexpr double kBesideEdge = 1e-6;

/// Returns 1 or -1 if the node goes through the face between the step's start and its end: in the direction of the
/// face's normal or against it. Returns 0 otherwise. Takes heights above the face's plane as linear in time.
int passage(const btSoftBody::Node& node, const btSoftBody::Face& face) {
  Vec3d places[2][4];
  double heights[2];
  for (int at_end = 0; at_end < 2; ++at_end) {
    const NodePosition position = at_end == 1 ? kClassicEnds.end : kClassicEnds.start;
    Vec3d(&x)[4] = places[at_end];
    x[0] = to_doubles(node.*position);
    for (int i = 0; i < 3; ++i) x[i + 1] = to_doubles(face.m_n[i]->*position);
    const Vec3d area = cross(x[2] - x[1], x[3] - x[1]);
    heights[at_end] = dot(x[0] - x[1], area) / std::sqrt(dot(area, area));
  }
  if (!(heights[0] * heights[1] < 0)) return 0;
  const double time = heights[0] / (heights[0] - heights[1]);
  Vec3d x[4];
  for (int i = 0; i < 4; ++i) x[i] = (1 - time) * places[0][i] + time * places[1][i];
  const Vec3d area = cross(x[2] - x[1], x[3] - x[1]);
  for (int i = 1; i < 4; ++i) {
    const Vec3d edge = x[i % 3 + 1] - x[i];
    if (!(dot(area, cross(edge, x[0] - x[i])) >= -kBesideEdge * dot(area, area))) return 0;
  }
  return heights[1] > 0 ? 1 : -1;
}

}  // namespace

void AnchoredNodes::add(const btSoftBody& body) {
  for (const btSoftBody::DeformableNodeRigidAnchor& anchor : span_of(body.m_deformableAnchors)) {
    if (!anchor.m_cti.m_colObj->isStaticOrKinematicObject()) nodes_.insert(anchor.m_node);
  }
}

bool AnchoredNodes::has_one_of(const btSoftBody::Node& node, const btSoftBody::Face& face) const {
  if (nodes_.empty()) return false;
  return nodes_.count(&node) != 0 || std::any_of(std::begin(face.m_n), std::end(face.m_n),
                                                 [this](const auto* corner) { return nodes_.count(corner) != 0; });
}

bool is_finer_than_margins(const WorldMirror::Member& member, std::uint32_t face) {
  if (face >= member.mesh.face_count) return false;
  const btScalar margins = margin_sum(*member.body, *member.body);
  // Bullet's m_ra is twice the area.
  return member.face(face).m_ra <= 2 * margins * margins;
}

double distance_from_face(const MemberContact& found) {
  const auto place = [&](int i) { return to_doubles(found.node(i).m_x); };
  return closest_points_vertex_triangle(place(0), place(1), place(2), place(3)).distance();
}

EdgeContact edge_contact_of(const MemberContact& found) {
  const Contact& contact = found.contact;
  const auto side = [&](const WorldMirror::Member& member, int first) {
    EdgeContact::Side result{member.body, {}, {}};
    for (int i = 0; i < 2; ++i) {
      result.nodes[i] = static_cast<int>(contact.vertices[first + i]);
      result.weights[i] = btScalar(contact.weights[first + i]);
    }
    return result;
  };
  return {side(found.a, 0), side(found.b, 2), to_bullet(contact.normal), btScalar(contact.distance),
          btScalar(contact.time_of_impact)};
}

bool ClassicContacts::is_turned(const MemberContact& found, Detection detection, bool is_chosen, FirstFan& fan) {
  const bool may_turn = is_chosen || found.a.body == found.b.body;
  if (!may_turn || detection != Detection::dcd) return false;
  const int direction = passage(found.node(0), found.face());
  const bool leaves_closed_body = direction == found.b.mesh.outward && &found.a != &found.b;
  return direction != 0 && !leaves_closed_body && !bullet::is_tangled(found, kClassicEnds, fan);
}

bool ClassicContacts::is_tangled(const MemberContact& found, Detection detection, FirstFan& fan) {
  return detection == Detection::dcd && &found.a != &found.b && bullet::is_tangled(found, kClassicEnds, fan);
}

std::optional<btSoftBody::SContact> ClassicContacts::contact_of(const MemberContact& found, Detection detection) {
  const Contact& contact = found.contact;
  btSoftBody& node_body = *found.a.body;
  btSoftBody& face_body = *found.b.body;
  if (!node_body.isActive()) return std::nullopt;
  btSoftBody::Node& node = found.node(0);
  btSoftBody::Face& face = found.face();
  const btScalar margin = contact_margin(node_body, face_body, node, detection);
  if (detection == Detection::dcd && (btScalar(contact.distance) > margin || !are_in_boxes_of_classic_trees(found))) {
    return std::nullopt;
  }

  const btVector3 weights = triangle_weights(contact.weights);
  const btScalar node_inverse_mass = node.m_im;
  const btScalar face_inverse_mass = inverse_mass_of(face_body, face, weights);
  const btScalar sum = node_inverse_mass + face_inverse_mass;
  if (!(sum > 0)) return std::nullopt;

  btSoftBody::SContact soft_contact;
  soft_contact.m_node = &node;
  soft_contact.m_face = &face;
  soft_contact.m_weights = weights;
  soft_contact.m_normal = to_bullet(contact.normal);
  soft_contact.m_margin = margin;
  soft_contact.m_friction = btMax(node_body.m_cfg.kDF, face_body.m_cfg.kDF);
  soft_contact.m_cfm[0] = node_inverse_mass / sum * node_body.m_cfg.kSHR;
  soft_contact.m_cfm[1] = face_inverse_mass / sum * face_body.m_cfg.kSHR;
  return soft_contact;
}

void ClassicContacts::carry(const ContactShare& share, Entry& entry) {
  if (share.is_turned) entry.m_normal *= -1;
  if (share.count > 1) entry.m_friction = 1 - btPow(1 - entry.m_friction, btScalar(share.count));
  entry.m_margin -= share.margin_cut;
}

btScalar ClassicContacts::margin_cut(const MemberContact& one, Span<const Entry> carried, std::size_t place) {
  const btSoftBody::SContact& given = carried[place];
  if (!(approach_of(given) > 0)) return 0;
  const btScalar grown_by = given.m_margin - margin_sum(*one.a.body, *one.b.body);
  if (!(grown_by > 0)) return 0;
  return btMin(given.m_margin - joint_margin(carried, place, one.a.body->m_cfg.piterations), grown_by);
}

void ClassicContacts::add_edges(const MemberContact& found, const AnchoredNodes& /*anchored*/,
                                SolverContactBatch<Entry>& out) {
  const EdgeOnFace edge = edge_on_face(found);
  if (!edge.node_body->isActive()) return;
  const btScalar face_inverse_mass = inverse_mass_of_edge(edge);
  ContactInverseMass inverse_mass;
  for (int side = 0; side < 2; ++side) inverse_mass.add(edge.node_weights[side], edge.nodes[side]->m_im);
  for (int corner = 0; corner < 3 && face_inverse_mass > 0; ++corner) {
    if (edge.weights[corner] > 0) inverse_mass.add(edge.weights[corner], edge.face->m_n[corner]->m_im);
  }
  const btScalar sum = inverse_mass.value();
  if (!(sum > 0)) return;

  for (int side = 0; side < 2; ++side) {
    btSoftBody::SContact contact;
    contact.m_node = edge.nodes[side];
    contact.m_face = edge.face;
    contact.m_weights = edge.weights;
    contact.m_normal = edge.normal;
    contact.m_margin = margin_sum(*edge.node_body, *edge.face_body) + edge.further[side];
    contact.m_friction = btMax(edge.node_body->m_cfg.kDF, edge.face_body->m_cfg.kDF);
    contact.m_cfm[0] = edge.node_weights[side] * edge.nodes[side]->m_im / sum * edge.node_body->m_cfg.kSHR;
    contact.m_cfm[1] = edge.node_weights[side] * face_inverse_mass / sum * edge.face_body->m_cfg.kSHR;
    out.add(*edge.node_body, contact);
  }
}

std::optional<btSoftBody::DeformableFaceNodeContact> DeformableContacts::contact_of(const MemberContact& found,
                                                                                    Detection /*detection*/) {
  if (!found.a.body->isActive() || !are_near_for_bullet(found)) return std::nullopt;
  btSoftBody::Face& face = found.face();
  btSoftBody::Node& node = found.node(0);
  const btVector3 weights = triangle_weights(found.contact.weights);
  if (!have_velocities({&node}) || !have_velocities(face.m_n)) return std::nullopt;
  if (!(node.m_im + inverse_mass_of(*found.b.body, face, weights) > 0)) return std::nullopt;
  btSoftBody::DeformableFaceNodeContact deformable = deformable_contact(*found.a.body, node, *found.b.body, face);
  deformable.m_bary = weights;
  deformable.m_normal = deformable_normal(found, node, face);
  deformable.m_margin = margin_sum(*found.a.body, *found.b.body);
  return deformable;
}

void DeformableContacts::add_edges(const MemberContact& found, const AnchoredNodes& anchored,
                                   SolverContactBatch<Entry>& out) {
  const EdgeOnFace edge = edge_on_face(found);
  if (!edge.node_body->isActive()) return;
  if (!have_velocities(edge.nodes) || !have_velocities(edge.face->m_n)) return;
  const btScalar face_inverse_mass = inverse_mass_of(*edge.face_body, *edge.face, edge.weights);
  for (int side = 0; side < 2; ++side) {
    if (!(edge.nodes[side]->m_im + face_inverse_mass > 0)) continue;
    if (anchored.has_one_of(*edge.nodes[side], *edge.face)) continue;
    btSoftBody::DeformableFaceNodeContact deformable =
        deformable_contact(*edge.node_body, *edge.nodes[side], *edge.face_body, *edge.face);
    deformable.m_bary = edge.weights;
    deformable.m_normal = edge.normal;
    deformable.m_margin = margin_sum(*edge.node_body, *edge.face_body) + edge.further[side];
    out.add(*edge.node_body, deformable);
  }
}

}  // namespace softcd::bullet

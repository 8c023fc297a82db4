#include "read_out/contact_reader.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "bodies/node_ends.hpp"
#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

using Feature = ContactSide::Feature;

int index_of(const btSoftBody& body, const btSoftBody::Node& node) {
  return static_cast<int>(&node - &body.m_nodes[0]);
}

ContactSide node_side(const btSoftBody& body, const btSoftBody::Node& node) {
  ContactSide side;
  side.feature = Feature::node;
  side.nodes[0] = index_of(body, node);
  side.weights[0] = 1;
  side.position = node.m_x;
  return side;
}

ContactSide face_side(const btSoftBody& body, const btSoftBody::Face& face, const btVector3& weights) {
  ContactSide side;
  const bool is_link = body.m_faces.size() == 0;
  side.feature = is_link ? Feature::edge : Feature::face;
  side.face = is_link ? -1 : static_cast<int>(&face - &body.m_faces[0]);
  for (int i = 0; i < (is_link ? 2 : 3); ++i) {
    side.nodes[i] = index_of(body, *face.m_n[i]);
    side.weights[i] = weights[i];
    side.position += weights[i] * face.m_n[i]->m_x;
  }
  return side;
}

/// Returns the side of an edge-edge contact whose first vertex is contact.vertices[first].
ContactSide edge_side(const btSoftBody& body, const Contact& contact, int first) {
  ContactSide side;
  side.feature = Feature::edge;
  for (int i = 0; i < 2; ++i) {
    side.nodes[i] = static_cast<int>(contact.vertices[first + i]);
    side.weights[i] = btScalar(contact.weights[first + i]);
    side.position += side.weights[i] * body.m_nodes[side.nodes[i]].m_x;
  }
  return side;
}

void turn_round(ReadContact& read) {
  std::swap(read.contact.a, read.contact.b);
  read.contact.normal = -read.contact.normal;
  read.b = std::exchange(read.a, static_cast<const btSoftBody*>(read.b));
  read.owner_is_b = !read.owner_is_b;
}

}  // namespace

ContactReader::ContactReader(Span<btSoftBody* const> bodies, const NotesOfStep& notes) : notes_(notes) {
  for (const btSoftBody* body : bodies) {
    const std::size_t order = orders_.size();
    orders_.emplace(body, order);
    if (body->m_faces.size() > 0) faces_.push_back({&body->m_faces[0], body->m_faces.size(), body, order});
  }
  std::sort(faces_.begin(), faces_.end(),
            [](const FaceRange& a, const FaceRange& b) { return std::less<>()(a.first, b.first); });
}

const ContactReader::FaceRange* ContactReader::range_of(const btSoftBody::Face& face) const {
  const auto after = std::upper_bound(
      faces_.begin(), faces_.end(), &face,
      [](const btSoftBody::Face* key, const FaceRange& range) { return std::less<>()(key, range.first); });
  if (after == faces_.begin()) return nullptr;
  const FaceRange& range = *std::prev(after);
  return std::less<>()(&face, range.first + range.count) ? &range : nullptr;
}

std::size_t ContactReader::order_of(const btSoftBody& body) const {
  return orders_.at(&body);
}

const ContactNotes::Note* ContactReader::note_on_rigid(const ContactSource& source) const {
  const ContactNotes::Note* note = notes_.rigid_meshes.find(*source.owner, source.array, source.first);
  return note != nullptr ? note : notes_.convex_shapes.find(*source.owner, source.array, source.first);
}

ReadContact ContactReader::rigid_contact(const btSoftBody::sCti& contact, const ContactSide& side, btScalar distance,
                                         const ContactSource& source) const {
  const btSoftBody& owner = *source.owner;
  ReadContact read{&owner, contact.m_colObj, {}, source};
  read.contact.a = side;
  read.contact.b.feature = Feature::object;
  read.contact.b.position = side.position - contact.m_normal * (distance + margin_of(owner));
  read.contact.normal = contact.m_normal;
  read.contact.depth = -distance;
  const ContactNotes::Note* note = note_on_rigid(source);
  read.contact.time_of_impact = note != nullptr ? btScalar(note->contact.time_of_impact) : btScalar(1);
  return read;
}

/// `node` belongs to the first of the contact's entries.
ReadContact ContactReader::edge_contact(const btSoftBody::Node& node, const ContactNotes::Note& note) const {
  ReadContact read{note.a, note.b, {}, note.source};
  const int index = index_of(*note.source.owner, node);
  const auto is_node = [index](std::uint32_t vertex) { return static_cast<int>(vertex) == index; };
  read.owner_is_b =
      note.source.owner != note.a || !(is_node(note.contact.vertices[0]) || is_node(note.contact.vertices[1]));
  read.contact.a = edge_side(*note.a, note.contact, 0);
  read.contact.b = edge_side(*note.b, note.contact, 2);
  read.contact.normal = to_bullet(note.contact.normal);
  if (order_of(*note.b) < order_of(*note.a)) turn_round(read);
  read.contact.time_of_impact = btScalar(note.contact.time_of_impact);
  read.contact.depth = margin_of(*note.a) + margin_of(*note.b) -
                       read.contact.normal.dot(read.contact.a.position - read.contact.b.position);
  return read;
}

template <class SoftContact>
void ContactReader::read_soft(const btSoftBody& owner, const btAlignedObjectArray<SoftContact>& array,
                              btVector3 SoftContact::*weights, std::vector<ReadContact>& contacts) const {
  for (int i = 0; i < array.size(); ++i) {
    const ContactNotes::Note* note = notes_.soft.find(owner, ContactArray::soft, i);
    if (note != nullptr && note->a != nullptr) {
      contacts.push_back(edge_contact(*array[i].m_node, *note));
      i += note->source.count - 1;
      continue;
    }
    const SoftContact& entry = array[i];
    const FaceRange* range = range_of(*entry.m_face);
    if (range == nullptr) continue;
    ReadContact read{&owner, range->body, {}, {&owner, ContactArray::soft, i}};
    read.contact.a = node_side(owner, *entry.m_node);
    read.contact.b = face_side(*range->body, *entry.m_face, entry.*weights);
    read.contact.normal = entry.m_normal;
    read.contact.depth = entry.m_margin - entry.m_normal.dot(read.contact.a.position - read.contact.b.position);
    read.contact.time_of_impact = note != nullptr ? btScalar(note->contact.time_of_impact) : btScalar(1);
    if (range->order < order_of(owner)) turn_round(read);
    contacts.push_back(read);
  }
}

void ContactReader::read_classic(const btSoftBody& owner, std::vector<ReadContact>& contacts) const {
  read_soft(owner, owner.m_scontacts, &btSoftBody::SContact::m_weights, contacts);
  for (int i = 0; i < owner.m_rcontacts.size(); ++i) {
    const btSoftBody::RContact& entry = owner.m_rcontacts[i];
    const ContactSource source = {&owner, ContactArray::rigid_node, i};
    // An entry for a contact of a face or link has a plane that does not say where the node should be.
    const ContactNotes::Note* of_face = note_on_rigid(source);
    const btScalar distance = of_face != nullptr ? btScalar(of_face->contact.distance)
                                                 : entry.m_cti.m_normal.dot(entry.m_node->m_x) + entry.m_cti.m_offset;
    contacts.push_back(rigid_contact(entry.m_cti, node_side(owner, *entry.m_node), distance, source));
  }
}

void ContactReader::read_deformable(const btSoftBody& owner, std::vector<ReadContact>& contacts) const {
  read_soft(owner, owner.m_faceNodeContacts, &btSoftBody::DeformableFaceNodeContact::m_bary, contacts);
  for (int i = 0; i < owner.m_nodeRigidContacts.size(); ++i) {
    const btSoftBody::DeformableNodeRigidContact& entry = owner.m_nodeRigidContacts[i];
    contacts.push_back(rigid_contact(entry.m_cti, node_side(owner, *entry.m_node), entry.m_cti.m_offset,
                                     {&owner, ContactArray::rigid_node, i}));
  }
  for (int i = 0; i < owner.m_faceRigidContacts.size(); ++i) {
    const btSoftBody::DeformableFaceRigidContact& entry = owner.m_faceRigidContacts[i];
    contacts.push_back(rigid_contact(entry.m_cti, face_side(owner, *entry.m_face, entry.m_bary), entry.m_cti.m_offset,
                                     {&owner, ContactArray::rigid_face, i}));
  }
}

}  // namespace softcd::bullet

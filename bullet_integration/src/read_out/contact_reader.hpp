#pragma once

#include <unordered_map>
#include <vector>

#include "contacts/contact_notes.hpp"
#include "softcd/bullet/body_contacts.hpp"

/// Reads the contacts for Bullet's solver from Bullet's arrays, whether Bullet or softcd has written them.
namespace softcd::bullet {

/// The notes of softcd's detectors, each on its own entries in Bullet's arrays.
struct NotesOfStep {
  const ContactNotes& soft;
  const ContactNotes& rigid_meshes;
  const ContactNotes& convex_shapes;
};

/// A contact with the bodies of its sides. `owner_is_b` says whether the owner of the entry is on side b.
struct ReadContact {
  const btSoftBody* a;
  const btCollisionObject* b;
  BodyContact contact;
  ContactSource source;
  bool owner_is_b = false;
};

/// Reads the contacts of one step of a world. `bodies` are its soft bodies, and must not change. In a contact between
/// two of them, side a is the one that comes first in `bodies`.
class ContactReader {
 public:
  /// All arguments must outlive it.
  ContactReader(Span<btSoftBody* const> bodies, const NotesOfStep& notes);

  /// Appends the contacts in the arrays of the classic worlds, or of the deformable one.
  void read_classic(const btSoftBody& owner, std::vector<ReadContact>& contacts) const;
  void read_deformable(const btSoftBody& owner, std::vector<ReadContact>& contacts) const;

 private:
  struct FaceRange {
    const btSoftBody::Face* first;
    int count;
    const btSoftBody* body;
    std::size_t order;  ///< of the body in the world
  };

  const FaceRange* range_of(const btSoftBody::Face& face) const;
  std::size_t order_of(const btSoftBody& body) const;
  template <class SoftContact>
  void read_soft(const btSoftBody& owner, const btAlignedObjectArray<SoftContact>& array,
                 btVector3 SoftContact::*weights, std::vector<ReadContact>& contacts) const;
  ReadContact edge_contact(const btSoftBody::Node& node, const ContactNotes::Note& note) const;
  const ContactNotes::Note* note_on_rigid(const ContactSource& source) const;
  /// `distance` is that between `side` and the place to which the solver moves it.
  ReadContact rigid_contact(const btSoftBody::sCti& contact, const ContactSide& side, btScalar distance,
                            const ContactSource& source) const;

  std::vector<FaceRange> faces_;  ///< sorted by address
  std::unordered_map<const btSoftBody*, std::size_t> orders_;
  NotesOfStep notes_;
};

/// ContactReader's function for a kind of world.
using ReadContacts = void (ContactReader::*)(const btSoftBody& owner, std::vector<ReadContact>& contacts) const;

}  // namespace softcd::bullet

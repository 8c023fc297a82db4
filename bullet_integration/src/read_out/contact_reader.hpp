#pragma once

#include <unordered_map>
#include <vector>

#include "contacts/contact_notes.hpp"
#include "softcd/bullet/body_contacts.hpp"

/// Reads the contacts that Bullet's solver gets back from Bullet's own arrays, whoever has put them there.
namespace softcd::bullet {

/// What softcd's detectors have noted about the entries in Bullet's arrays, each about its own.
struct NotesOfStep {
  const ContactNotes& soft;
  const ContactNotes& rigid_meshes;
  const ContactNotes& convex_shapes;
};

/// A contact with the bodies of its sides. `owner_is_b`: the entry's node, or its soft body, is on side b.
struct ReadContact {
  const btSoftBody* a;
  const btCollisionObject* b;
  BodyContact contact;
  ContactSource source;
  bool owner_is_b = false;
};

/// Of a step of one world: `bodies` are its soft bodies, which do not change meanwhile. A contact between two of them
/// has the one that comes first there on side a.
class ContactReader {
 public:
  /// All outlive it.
  ContactReader(Span<btSoftBody* const> bodies, const NotesOfStep& notes);

  /// The contacts in the arrays of the classic worlds, or of the deformable one.
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
  /// `distance` is between `side` and where the solver wants it to be.
  ReadContact rigid_contact(const btSoftBody::sCti& contact, const ContactSide& side, btScalar distance,
                            const ContactSource& source) const;

  std::vector<FaceRange> faces_;  ///< by address
  std::unordered_map<const btSoftBody*, std::size_t> orders_;
  NotesOfStep notes_;
};

/// ContactReader's function for a kind of world.
using ReadContacts = void (ContactReader::*)(const btSoftBody& owner, std::vector<ReadContact>& contacts) const;

}  // namespace softcd::bullet

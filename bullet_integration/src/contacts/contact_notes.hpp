#pragma once

#include <cstdint>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/softcd.hpp"

namespace softcd::bullet {

/// Names an array of a soft body's contacts: with faces of soft bodies (m_scontacts, m_faceNodeContacts); of nodes with
/// rigid objects (m_rcontacts, m_nodeRigidContacts); of faces with rigid objects (m_faceRigidContacts).
enum class ContactArray : std::uint32_t { soft, rigid_node, rigid_face };

/// The place of a contact in Bullet's arrays: one entry, or the two of an edge-edge contact.
struct ContactSource {
  const btSoftBody* owner = nullptr;
  ContactArray array = ContactArray::soft;
  int first = 0;
  int count = 1;
};

/// Data on softcd's entries in Bullet's arrays for which these have no members.
class ContactNotes {
 public:
  struct Note {
    ContactSource source;
    const btSoftBody* a;  ///< the soft bodies of `contact`; null unless its edges touch
    const btSoftBody* b;
    Contact contact;
  };

  /// Removes all notes. Then add() throws nothing for up to `count` notes.
  void reset(std::size_t count);
  void add(const Note& note) { notes_.push_back(note); }
  /// Sorts the notes. Call it before find(), after all have been added.
  void arrange();
  /// Returns the note on the entry at `index`; null if there is none.
  const Note* find(const btSoftBody& owner, ContactArray array, int index) const;

 private:
  std::vector<Note> notes_;
};

}  // namespace softcd::bullet

#pragma once

#include <cstddef>
#include <vector>

#include "contacts/contact_notes.hpp"

namespace softcd::bullet {

/// Contacts of solvers, made of some of a query's contacts in a row.
template <class T>
class SolverContactBatch {
 public:
  /// Contacts in a row that one body gets.
  struct Run {
    btSoftBody* body;
    std::size_t first;  ///< in the batch
    std::size_t count;
    int place;  ///< of the first one in the body's array
  };

  void clear() {
    contacts.clear();
    runs.clear();
    notes.clear();
  }
  void add(btSoftBody& body, const T& contact) {
    if (runs.empty() || runs.back().body != &body) runs.push_back({&body, contacts.size(), 0, 0});
    ++runs.back().count;
    contacts.push_back(contact);
  }

  std::vector<T> contacts;
  std::vector<Run> runs;
  std::vector<ContactNotes::Note> notes;  ///< with places in the batch until write()
};

using SoftContactBatch = SolverContactBatch<btSoftBody::SContact>;
using DeformableContactBatch = SolverContactBatch<btSoftBody::DeformableFaceNodeContact>;

}  // namespace softcd::bullet

#include "contacts/contact_notes.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>

namespace softcd::bullet {
namespace {

std::tuple<std::uintptr_t, ContactArray, int> place_of(const ContactSource& source) {
  return {reinterpret_cast<std::uintptr_t>(source.owner), source.array, source.first};
}

}  // namespace

void ContactNotes::reset(std::size_t count) {
  notes_.clear();
  notes_.reserve(count);
}

void ContactNotes::arrange() {
  std::sort(notes_.begin(), notes_.end(),
            [](const Note& a, const Note& b) { return place_of(a.source) < place_of(b.source); });
}

const ContactNotes::Note* ContactNotes::find(const btSoftBody& owner, ContactArray array, int index) const {
  const ContactSource wanted{&owner, array, index};
  const auto after = std::upper_bound(
      notes_.begin(), notes_.end(), wanted,
      [](const ContactSource& key, const Note& note) { return place_of(key) < place_of(note.source); });
  if (after == notes_.begin()) return nullptr;
  const Note& note = *std::prev(after);
  const bool has_it =
      note.source.owner == &owner && note.source.array == array && index < note.source.first + note.source.count;
  return has_it ? &note : nullptr;
}

}  // namespace softcd::bullet

#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "contacts/contact_walks.hpp"
#include "contacts/contact_writer.hpp"

namespace softcd::bullet {

/// The contacts that Bullet's solver gets in a step. Several threads make and write them, in the order of one thread.
class SolverContacts {
 public:
  using ShareOf = std::function<ContactShare(std::size_t, const MemberContact&)>;

  SolverContacts() = default;
  SolverContacts(const SolverContacts&) = delete;
  SolverContacts& operator=(const SolverContacts&) = delete;
  virtual ~SolverContacts() = default;

  /// Makes the contacts of a step. Calls share_of(index, contact) from several threads.
  virtual void make(const WorldMirror& mirror, Span<const Contact> contacts, Detection detection, bool keeps_notes,
                    const ShareOf& share_of) = 0;
  /// Returns how many contacts have a note.
  virtual std::size_t note_count() const = 0;
  /// Appends the contacts to Bullet's arrays, and adds the notes, for which there must be room.
  virtual void write(ContactNotes& notes) noexcept = 0;
};

/// The SolverContacts of one kind of world. `Kind` has the type and the array of contacts, and adds those of a query's
/// contact to a batch.
template <class Kind>
class SolverContactsOf final : public SolverContacts {
  using Batch = SolverContactBatch<typename Kind::Contact>;

 public:
  void make(const WorldMirror& mirror, Span<const Contact> contacts, Detection detection, bool keeps_notes,
            const ShareOf& share_of) override {
    count_ = (contacts.size() + kContactsOfBatch - 1) / kContactsOfBatch;
    if (count_ > batches_.size()) batches_.resize(count_);
    for_each_batch([&](std::size_t b) {
      Batch& batch = batches_[b];
      batch.clear();
      std::size_t i = b * kContactsOfBatch;
      const std::size_t end = std::min(i + kContactsOfBatch, contacts.size());
      mirror.for_each_contact({contacts.begin() + i, end - i}, [&](const MemberContact& found) {
        const ContactShare share = share_of(i++, found);
        if (share.count == 0) return;
        const std::size_t before = batch.contacts.size();
        Kind::add(found, detection, share, batch);
        if (keeps_notes && batch.contacts.size() > before) add_note(found, before, batch);
      });
    });
  }

  std::size_t note_count() const override {
    std::size_t count = 0;
    for (std::size_t b = 0; b < count_; ++b) count += batches_[b].notes.size();
    return count;
  }

  void write(ContactNotes& notes) noexcept override {
    for (std::size_t b = 0; b < count_; ++b) take_places(batches_[b], notes);
    const auto copy = [&](std::size_t b) { copy_to_places(batches_[b]); };
    try {
      for_each_batch(copy);
    } catch (...) {
      // Runs without parallelism, where memory or threads are lacking.
      for (std::size_t b = 0; b < count_; ++b) copy(b);
    }
  }

 private:
  static constexpr std::size_t kContactsOfBatch = 128;

  template <class F>
  void for_each_batch(const F& f) {
    if (count_ == 1) {
      f(std::size_t{0});
    } else {
      parallel::for_each(count_, f);
    }
  }

  /// The contacts are the last of the batch's last run.
  static void add_note(const MemberContact& found, std::size_t first, Batch& batch) {
    const bool is_edges = found.contact.kind == ContactKind::edge_edge;
    const auto count = static_cast<int>(batch.contacts.size() - first);
    batch.notes.push_back({{batch.runs.back().body, ContactArray::soft, static_cast<int>(first), count},
                           is_edges ? found.a.body : nullptr,
                           is_edges ? found.b.body : nullptr,
                           found.contact});
  }

  /// Enlarges the bodies' arrays by the batch's contacts, whose values are still missing.
  static void take_places(Batch& batch, ContactNotes& notes) {
    auto note = batch.notes.begin();
    for (auto& run : batch.runs) {
      auto& array = Kind::array(*run.body);
      run.place = array.size();
      const int size = run.place + static_cast<int>(run.count);
      if (size > array.capacity()) array.reserve(std::max(size, 2 * array.capacity()));
      array.resizeNoInitialize(size);
      for (; note != batch.notes.end() && std::size_t(note->source.first) < run.first + run.count; ++note) {
        note->source.first += run.place - static_cast<int>(run.first);
        notes.add(*note);
      }
    }
  }

  static void copy_to_places(const Batch& batch) {
    for (const auto& run : batch.runs) {
      std::uninitialized_copy_n(batch.contacts.begin() + static_cast<std::ptrdiff_t>(run.first), run.count,
                                &Kind::array(*run.body)[run.place]);
    }
  }

  std::vector<Batch> batches_;
  std::size_t count_ = 0;  ///< of the batches that are in use
};

}  // namespace softcd::bullet

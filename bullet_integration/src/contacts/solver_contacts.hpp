#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "contacts/contact_economy.hpp"
#include "softcd/core/parallel.hpp"

namespace softcd::bullet {

/// The contacts that Bullet's solver gets in a step. Several threads make and write them, in the order of one thread.
/// Owned by ContactDetection.
class SolverContacts {
 public:
  /// The contacts of a query, and how to make those of the solver.
  struct Step {
    const WorldMirror& mirror;
    Span<const Contact> contacts;
    Detection detection;
    const ContactEconomy& economy;
    const AnchoredNodes& anchored;
    bool keeps_notes;
    /// Returns whether the solver may get the contact. Called once for each contact, from several threads.
    std::function<bool(std::size_t, const MemberContact&)> may_get;
  };

  SolverContacts() = default;
  SolverContacts(const SolverContacts&) = delete;
  SolverContacts& operator=(const SolverContacts&) = delete;
  virtual ~SolverContacts() = default;

  /// Makes the contacts of a step: judges each contact of the query once, chooses among them, and passes over them
  /// once.
  virtual void make(const Step& step) = 0;
  /// Returns how many contacts the solver gets. It counts a contact of edges once.
  virtual ContactCounts given() const = 0;
  /// Returns how many contacts have a note.
  virtual std::size_t note_count() const = 0;
  /// Returns the pairs of bodies with contacts that the economy has judged as tangled, some more than once.
  virtual std::vector<ProbeBodies> tangled_bodies() const = 0;
  /// Appends the contacts to Bullet's arrays, and adds the notes, for which `notes` must have capacity.
  virtual void write(ContactNotes& notes) noexcept = 0;
};

/// The SolverContacts of one kind of world. `Kind` has the type and the array of contacts, and the formulas.
template <class Kind>
class SolverContactsOf final : public SolverContacts {
  using T = typename Kind::Entry;

  /// Consecutive contacts of a query, as contacts of the solver.
  struct Batch : SolverContactBatch<T> {
    ContactCounts given;
    std::vector<ProbeBodies> tangled;
    // One node's contacts with one body, as they are gathered:
    std::vector<NodeContact> of_node;
    std::vector<T> made;  ///< of of_node
    std::vector<std::uint32_t> nearest_first;
    std::vector<T> carried;

    void reset() {
      this->clear();
      given = {};
      tangled.clear();
      of_node.clear();
      made.clear();
    }
  };

 public:
  void make(const Step& step) override {
    count_ = (step.contacts.size() + kContactsOfBatch - 1) / kContactsOfBatch;
    if (count_ > batches_.size()) batches_.resize(count_);
    for_each_batch([&](std::size_t b) { make(step, b, batches_[b]); });
  }

  ContactCounts given() const override {
    ContactCounts sum;
    for (std::size_t b = 0; b < count_; ++b) {
      sum.of_nodes += batches_[b].given.of_nodes;
      sum.of_edges += batches_[b].given.of_edges;
    }
    return sum;
  }

  std::size_t note_count() const override {
    std::size_t count = 0;
    for (std::size_t b = 0; b < count_; ++b) count += batches_[b].notes.size();
    return count;
  }

  std::vector<ProbeBodies> tangled_bodies() const override {
    std::vector<ProbeBodies> pairs;
    for (std::size_t b = 0; b < count_; ++b) {
      pairs.insert(pairs.end(), batches_[b].tangled.begin(), batches_[b].tangled.end());
    }
    return pairs;
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

  /// Returns the first contact from `i` on that is not chosen together with the one before it.
  static std::size_t first_of_choice(const Step& step, std::size_t i) {
    i = std::min(i, step.contacts.size());
    while (i > 0 && i < step.contacts.size() &&
           step.economy.are_of_one_choice(step.contacts[i - 1], step.contacts[i])) {
      ++i;
    }
    return i;
  }

  static void make(const Step& step, std::size_t b, Batch& batch) {
    batch.reset();
    std::size_t i = first_of_choice(step, b * kContactsOfBatch);
    const std::size_t end = first_of_choice(step, (b + 1) * kContactsOfBatch);
    const Contact* before = nullptr;
    FirstFan fan;
    step.mirror.for_each_contact({step.contacts.begin() + i, end - i}, [&](const MemberContact& found) {
      if (before != nullptr && !step.economy.are_of_one_choice(*before, found.contact)) choose(step, batch);
      before = &found.contact;
      if (!step.may_get(i++, found)) return;
      if (found.contact.kind == ContactKind::vertex_triangle) {
        judge(step, found, fan, batch);
      } else if (step.economy.keeps(found)) {
        ++batch.given.of_edges;
        const std::size_t first = batch.contacts.size();
        Kind::add_edges(found, step.anchored, batch);
        add_note(step, found, first, batch);
      }
    });
    choose(step, batch);
  }

  /// Contacts of the same bodies often follow each other.
  static void note_tangled(const ProbeBodies& bodies, std::vector<ProbeBodies>& tangled) {
    const bool is_last = !tangled.empty() && tangled.back().a == bodies.a && tangled.back().b == bodies.b;
    if (!is_last) tangled.push_back(bodies);
  }

  /// Gathers the contact for choose(), or adds it if there is no choice.
  static void judge(const Step& step, const MemberContact& found, FirstFan& fan, Batch& batch) {
    const std::optional<T> contact = Kind::contact_of(found, step.detection);
    if (!contact) return;
    const bool is_chosen = step.economy.chooses();
    bool is_turned = false, is_tangled = false;
    if constexpr (Kind::kSolvesInTurns) {
      is_turned = Kind::is_turned(found, step.detection, is_chosen, fan);
      is_tangled = is_chosen && Kind::is_tangled(found, step.detection, fan);
    }
    if (is_tangled) note_tangled({found.a.id, found.b.id}, batch.tangled);
    if (is_chosen) {
      batch.of_node.push_back(node_contact(found, is_turned, is_tangled));
      batch.made.push_back(*contact);
    } else {
      add(step, found, {/*count=*/1, /*margin_cut=*/0, is_turned}, *contact, batch);
    }
  }

  static void add(const Step& step, const MemberContact& found, const ContactShare& share, T contact, Batch& batch) {
    ++batch.given.of_nodes;
    if constexpr (Kind::kSolvesInTurns) Kind::carry(share, contact);
    const std::size_t first = batch.contacts.size();
    batch.add(*found.a.body, contact);
    add_note(step, found, first, batch);
  }

  /// Adds those of the gathered contacts that the economy chooses.
  static void choose(const Step& step, Batch& batch) {
    if (batch.of_node.empty()) return;
    step.economy.choose(batch.of_node, batch.nearest_first);
    if constexpr (Kind::kSolvesInTurns) cut_margins(batch);
    for (std::size_t i = 0; i < batch.of_node.size(); ++i) {
      const NodeContact& each = batch.of_node[i];
      if (each.share.count > 0) add(step, each.found, each.share, batch.made[i], batch);
    }
    batch.of_node.clear();
    batch.made.clear();
  }

  /// Cuts the margins of owners with contacts of several normals. Contacts of one normal are with one point of the
  /// body: the first one to be solved ends the approach for all.
  static void cut_margins(Batch& batch) {
    for (std::uint32_t owner = 0; owner < batch.of_node.size(); ++owner) {
      NodeContact& one = batch.of_node[owner];
      if (one.share.count <= 1) continue;
      batch.carried.clear();
      bool are_of_one_normal = true;
      std::size_t place = 0;
      for (std::uint32_t i = 0; i < batch.of_node.size(); ++i) {
        const NodeContact& each = batch.of_node[i];
        if (each.owner != owner) continue;
        if (i == owner) place = batch.carried.size();
        batch.carried.push_back(batch.made[i]);
        are_of_one_normal &= each.found.contact.normal == one.found.contact.normal;
      }
      if (!are_of_one_normal) one.share.margin_cut = Kind::margin_cut(one.found, batch.carried, place);
    }
  }

  /// Notes contacts from `first` on, if there are any. They are the last of the batch's last run.
  static void add_note(const Step& step, const MemberContact& found, std::size_t first, Batch& batch) {
    const auto count = static_cast<int>(batch.contacts.size() - first);
    if (!step.keeps_notes || count == 0) return;
    const bool is_edges = found.contact.kind == ContactKind::edge_edge;
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

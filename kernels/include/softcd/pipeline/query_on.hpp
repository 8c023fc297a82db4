#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>

#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/memory_account.hpp"
#include "softcd/pipeline/workspace.hpp"

namespace softcd {

/// Makes a buffer hold these values.
template <class Backend, class Buffer, class T>
void upload_values(Backend& backend, Buffer& buffer, Span<const T> values) {
  buffer.reserve(backend, values.size(), 0);
  backend.upload(buffer, values);
}

/// A query's memory on a backend. `session` is the last member, so that it is destroyed first: its work may still use
/// the others.
template <class Backend>
struct QueryOn final : QueryMemory {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;

  explicit QueryOn(std::shared_ptr<MemoryAccount> its_account) : account(std::move(its_account)) {}

  void release() override {
    bodies_number = 0;
    bodies = {};
    partner_begin = {};
    partners = {};
    contacts = {};
    body_begin = {};
    contact_counts = {};
  }

  /// Returns whether the backend has these bodies already.
  bool has(const SceneBodies& its_bodies) const { return its_bodies.number != 0 && its_bodies.number == bodies_number; }
  void upload(Backend& backend, const SceneBodies& its_bodies) {
    upload_values(backend, bodies, its_bodies.bodies);
    upload_values(backend, partner_begin, its_bodies.partner_begin);
    const std::uint64_t count = its_bodies.partners.size();
    if (count > partners.capacity()) partners.reserve(backend, count + count / 4, 0);
    upload_values(backend, partners, its_bodies.partners);
  }

  std::shared_ptr<MemoryAccount> account;  ///< of the buffers
  std::uint64_t bodies_number = 0;         ///< SceneBodies::number of what the next three hold
  Buffer<SceneBody> bodies;
  Buffer<std::uint64_t> partner_begin;
  Buffer<std::uint32_t> partners;
  Buffer<Contact> contacts;
  // Only if contacts stay on the backend; see DeviceContacts and PendingContacts:
  Buffer<std::uint64_t> body_begin;
  Buffer<ContactCounts> contact_counts;
  std::array<std::uint64_t, kListCount> capacities{};  ///< of the lists, after the last detection
  std::uint64_t guessed_for = 0;                       ///< triangles that the first capacities were guessed for
  std::uint64_t chunks = 1;                            ///< parts that the last detection's pair tests were made in
  std::uint64_t revision = 0;                          ///< the detector's, during the last detection
  bool orders_in_runs = true;                          ///< until some were too long
  bool lays_into_bins = true;                          ///< until some were too long
  ChunkCounts total{};                                 ///< of the last detection
  std::shared_ptr<Usefulness> usefulness = std::make_shared<Usefulness>();  ///< of what its detections keep
  typename Backend::Session session;
};

}  // namespace softcd

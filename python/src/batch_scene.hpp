#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "scene.hpp"

namespace softcd::python {

/// Contacts of several environments, one environment after the other.
struct ContactsOfEnvironments {
  std::unique_ptr<std::byte[]> contacts;  ///< Contact objects
  std::vector<std::int64_t> begins;       ///< where each environment's begin, and at last where the last ones end
};

/// Returns them as softcd.BatchContacts.
nb::object contacts_of_environments(ContactsOfEnvironments contacts);

/// Copies of the same bodies in one scene, each copy a batch, so that copies never touch. Body b of environment e is
/// the scene's body b * n + e, for n environments: all calls concern a body of all environments.
class BoundBatchScene : public BoundScene {
 public:
  BoundBatchScene(std::uint32_t environments, const SceneOptions& options, nb::object log);

  std::uint32_t environments() const { return environments_; }
  std::uint32_t bodies();

  std::uint32_t add_bodies(nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
                           const BodySettings& settings);
  void set_settings(std::uint32_t body, const BodySettings& settings);
  void set_positions(std::uint32_t body, nb::handle vertices_t0, nb::handle vertices_t1, bool check_finite);
  void set_ignored_pairs(const NumberPairs& pairs);
  void set_vertex_filters(std::uint32_t body, const std::optional<VertexBits>& groups,
                          const std::optional<VertexBits>& masks);
  void set_rest_positions(std::uint32_t body, nb::handle vertices);

  /// Copies contacts of a query, environment by environment, each as in a scene of its own. Called within call().
  ContactsOfEnvironments split(Span<const Contact> contacts, std::uint32_t max_threads) const;

 private:
  void require_whole() const;
  /// Throws InvalidInput unless there is such a body. Called within call().
  void require_body(std::uint32_t body) const;
  BodyId id_of(std::uint32_t body, std::uint32_t environment) const { return {body * environments_ + environment}; }

  std::uint32_t environments_;
  std::vector<std::uint32_t> vertex_counts_;  ///< of each body
  bool is_broken_ = false;                    ///< memory ran out while some environments had got a body
};

}  // namespace softcd::python

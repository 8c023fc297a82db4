#pragma once

#include <cstdint>

#include "softcd/core/count.hpp"
#include "softcd/stages/contact_tests.hpp"

namespace softcd {

/// Sort keys of found contacts, first feature above second, in as few bits as the scene needs.
struct MakeContactKey {
  const FeatureContact* contacts;
  std::uint32_t low_bits;  ///< number of bits of the second feature
  std::uint64_t* keys;
  std::uint32_t* order;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const std::uint64_t features = contacts[i].features;
    keys[i] = ((features >> 32) << low_bits) | (features & 0xFFFFFFFFULL);
    order[i] = i;
  }
};

struct TimeOfContact {
  const FeatureContact* contacts;

  SOFTCD_HD float operator()(std::uint32_t i) const { return contacts[i].time; }
};

/// Writes the contacts in sorted order with indices within their bodies.
template <ContactKind kKind>
struct WriteContact {
  SceneView scene;
  const FeatureContact* contacts;
  const std::uint32_t* order;
  Count before;  ///< contacts of the kinds written in front
  Contact* out;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const FeatureContact& found = contacts[order[i]];
    const FeatureVertices vertices = feature_vertices<kKind>(scene, found.features);
    const SceneBody& a = scene.bodies[scene.vertex_body[vertices.v[0]]];
    const SceneBody& b = scene.bodies[scene.vertex_body[vertices.v[3]]];
    constexpr bool kIsVertex = kKind == ContactKind::vertex_triangle;

    Contact contact;
    contact.kind = kKind;
    contact.body_a = BodyId{a.id};
    contact.body_b = BodyId{b.id};
    contact.feature_a = static_cast<std::uint32_t>(found.features >> 32) - (kIsVertex ? a.first_vertex : a.first_edge);
    contact.feature_b = static_cast<std::uint32_t>(found.features) - (kIsVertex ? b.first_triangle : b.first_edge);
    for (int corner = 0; corner < 4; ++corner) {
      const bool on_a = corner < (kIsVertex ? 1 : 2);
      contact.vertices[corner] = vertices.v[corner] - (on_a ? a.first_vertex : b.first_vertex);
      contact.weights[corner] = found.weights[corner];
    }
    contact.normal = found.normal;
    contact.distance = found.distance;
    contact.time_of_impact = found.time;
    out[before.get() + i] = contact;
  }
};

}  // namespace softcd

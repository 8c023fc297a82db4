#pragma once

#include <cstdint>

#include "softcd/core/count.hpp"
#include "softcd/stages/contact_order.hpp"
#include "softcd/stages/contact_tests.hpp"

namespace softcd {

struct TimeOfContact {
  const FeatureContact* contacts;

  SOFTCD_HD float operator()(std::uint32_t i) const { return contacts[i].time; }
};

/// Writes contacts with indices within their bodies.
struct WriteContact {
  SceneView scene;
  Contact* out;

  SOFTCD_HD void operator()(const FeatureContact& found, std::uint64_t place) const {
    const bool is_vertex = kind_of(found.features) == ContactKind::vertex_triangle;
    const FeatureVertices vertices = is_vertex ? feature_vertices<ContactKind::vertex_triangle>(scene, found.features)
                                               : feature_vertices<ContactKind::edge_edge>(scene, found.features);
    const SceneBody& a = scene.bodies[scene.vertex_body[vertices.v[0]]];
    const SceneBody& b = scene.bodies[scene.vertex_body[vertices.v[3]]];

    Contact contact;
    contact.kind = kind_of(found.features);
    contact.is_unsettled = found.is_unsettled != 0U;
    contact.unused = 0;
    contact.body_a = BodyId{a.id};
    contact.body_b = BodyId{b.id};
    contact.feature_a = first_feature(found.features) - (is_vertex ? a.first_vertex : a.first_edge);
    contact.feature_b = second_feature(found.features) - (is_vertex ? b.first_triangle : b.first_edge);
    for (int corner = 0; corner < 4; ++corner) {
      const bool on_a = corner < (is_vertex ? 1 : 2);
      contact.vertices[corner] = vertices.v[corner] - (on_a ? a.first_vertex : b.first_vertex);
      contact.weights[corner] = found.weights[corner];
    }
    contact.normal = found.normal;
    contact.distance = found.distance;
    contact.time_of_impact = found.time;
    out[place] = contact;
  }
};

/// Writes contacts in an order that was found by a sort.
struct WriteInOrder {
  WriteContact write;
  const FeatureContact* contacts;
  const std::uint32_t* order;

  SOFTCD_HD void operator()(std::uint32_t i) const { write(contacts[order[i]], i); }
};

/// Writes contacts to their places in runs. Skips runs that are too long.
struct WriteInRun {
  WriteContact write;
  RankInRun rank;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const std::uint64_t place = rank.place(i);
    if (place != kNoPlace) write(rank.contacts[i], place);
  }
};

}  // namespace softcd

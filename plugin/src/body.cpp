#include "body.hpp"

#include <algorithm>

namespace softcd {

Body make_body(BodyId id, const BodyDesc& desc) {
  Body body;
  body.id = id;
  body.topology = build_topology(desc.triangles, desc.vertex_count);
  body.settings = desc.settings;
  body.participation.ownership = body.topology.ownership;
  return body;
}

Participation participation_without(const std::vector<std::uint32_t>& stray_vertices, const Topology& topology) {
  Participation result;
  result.stray_vertices = stray_vertices;
  std::vector<std::uint8_t> left_out(topology.triangles.size(), 0);
  for (std::size_t t = 0; t < left_out.size(); ++t) {
    const auto& v = topology.triangles[t].v;
    left_out[t] = std::any_of(
        v, v + 3, [&](std::uint32_t i) { return std::binary_search(stray_vertices.begin(), stray_vertices.end(), i); });
    result.left_out_triangles += left_out[t];
  }
  result.ownership = assign_ownership(topology, left_out);
  for (std::size_t t = 0; t < left_out.size(); ++t) {
    if (left_out[t] != 0) result.ownership[t] = static_cast<Ownership>(kLeftOut);
  }
  return result;
}

}  // namespace softcd

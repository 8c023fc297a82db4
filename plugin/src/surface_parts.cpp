#include "surface_parts.hpp"

#include <limits>
#include <utility>

namespace softcd::detail {
namespace {

constexpr Box empty_box() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  return {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
}

/// Returns the boxes of a surface's parts. Vertices of no part have no triangle.
std::vector<Box> boxes_of_parts(const Surface& surface, const std::vector<std::uint32_t>& part_of_vertex) {
  std::vector<Box> boxes;
  for (std::uint32_t v = 0; v < part_of_vertex.size(); ++v) {
    const std::uint32_t part = part_of_vertex[v];
    if (part == kNoIndex) continue;
    if (part == boxes.size()) boxes.push_back(empty_box());
    boxes[part] = merged(boxes[part], box_of(surface.x[v]));
  }
  return boxes;
}

}  // namespace

Box box_of_surface(const Surface& surface) {
  Box box = empty_box();
  for (std::uint32_t t = 0; t < surface.mesh.face_count(); ++t) {
    if (!surface.has_face(t)) continue;
    for (const std::uint32_t v : surface.triangle(t).v) box = merged(box, box_of(surface.x[v]));
  }
  return box;
}

void SurfaceParts::follow(std::uint64_t revision) {
  if (std::exchange(revision_, revision) != revision) parts_.clear();
}

const SurfaceParts::PartOfVertex& SurfaceParts::parts_of(const Surface& surface) {
  const auto at = parts_.find(surface.id.value);
  if (at != parts_.end()) return at->second;
  VertexSets sets(surface.mesh.vertex_count);
  std::vector<bool> is_used(surface.mesh.vertex_count, false);
  for (std::uint32_t t = 0; t < surface.mesh.face_count(); ++t) {
    if (!surface.has_face(t)) continue;
    const Triangle triangle = surface.triangle(t);
    sets.join(triangle.v[0], triangle.v[1]);
    sets.join(triangle.v[0], triangle.v[2]);
    for (const std::uint32_t v : triangle.v) is_used[v] = true;
  }
  PartOfVertex parts(surface.mesh.vertex_count, kNoIndex);
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < surface.mesh.vertex_count; ++v) {
    if (is_used[v]) parts[v] = sets.find(v) == v ? count++ : parts[sets.find(v)];
  }
  return parts_.emplace(surface.id.value, std::move(parts)).first->second;
}

std::vector<SurfacePair> SurfaceParts::pairs_within_boxes(Span<const Surface> surfaces, const ProbeBodies& asked) {
  const auto is = [](BodyId one, BodyId id) { return one == BodyId() || one == id; };
  const auto is_about = [&](BodyId a, BodyId b) {
    return (is(asked.a, a) && is(asked.b, b)) || (is(asked.a, b) && is(asked.b, a));
  };
  std::vector<Box> boxes;
  for (const Surface& surface : surfaces) {
    const bool is_asked = is(asked.a, surface.id) || is(asked.b, surface.id);
    boxes.push_back(is_asked ? box_of_surface(surface) : empty_box());
  }
  std::vector<SurfacePair> pairs;
  for (const auto& [a, b] : box_pairs_.find(boxes)) {
    if (!is_about(surfaces[a].id, surfaces[b].id)) continue;
    if (surfaces[b].is_closed) pairs.push_back({a, b});
    if (surfaces[a].is_closed) pairs.push_back({b, a});
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<Box> part_boxes;  // of the last pair's surface
  std::uint32_t surface = kNoIndex;
  std::erase_if(pairs, [&](const SurfacePair& pair) {
    if (std::exchange(surface, pair.surface) != pair.surface) {
      part_boxes = boxes_of_parts(surfaces[pair.surface], parts_of(surfaces[pair.surface]));
    }
    const Box& bounds = boxes[pair.other];
    return std::none_of(part_boxes.begin(), part_boxes.end(), [&](const Box& part) { return contains(bounds, part); });
  });
  return pairs;
}

}  // namespace softcd::detail

#include "viewer/overlays.hpp"

#include <algorithm>
#include <cmath>

namespace softcd::demo {
namespace {

constexpr Rgba kYellow = {255, 225, 60, 255};
constexpr Rgba kGreen = {120, 255, 120, 255};
constexpr Rgba kWhite = {255, 255, 255, 255};
constexpr float kFaceOpacity = 0.22F;
constexpr float kMostFaceOpacity = 0.4F;
constexpr double kShrink = 0.03;  // of a cell's size on each side, so that neighbours can be told apart

Rgba faded(Rgba color, float opacity) {
  return {color[0], color[1], color[2], static_cast<std::uint8_t>(255 * opacity)};
}

/// Returns a colour from blue at 0 to red at 1.
Rgba color_of_share(float share) {
  constexpr std::array<Vec3f, 5> kStops = {
      {{40, 70, 200}, {30, 170, 210}, {70, 200, 90}, {245, 205, 60}, {220, 50, 40}}};
  const float place = std::clamp(share, 0.0F, 1.0F) * static_cast<float>(kStops.size() - 1);
  const std::size_t stop = std::min(static_cast<std::size_t>(place), kStops.size() - 2);
  const Vec3f color = lerp(kStops[stop], kStops[stop + 1], place - static_cast<float>(stop));
  return {static_cast<std::uint8_t>(color.x), static_cast<std::uint8_t>(color.y), static_cast<std::uint8_t>(color.z),
          255};
}

/// Returns a number from 0, for no tests, to 1. The square root separates cells with few tests.
float heat(std::uint64_t tests, std::uint64_t most) {
  return most == 0 ? 0.0F : std::sqrt(static_cast<float>(tests) / static_cast<float>(most));
}

void append_line(Vec3d a, Vec3d b, Rgba color, std::vector<OverlayVertex>& out) {
  out.push_back({vec3_cast<float>(a), color});
  out.push_back({vec3_cast<float>(b), color});
}

/// Returns a corner of the box. Bit a of its number selects the high end of axis a.
Vec3d corner_of_box(Vec3d low, double size, unsigned corner) {
  return {low.x + ((corner & 1U) != 0 ? size : 0), low.y + ((corner & 2U) != 0 ? size : 0),
          low.z + ((corner & 4U) != 0 ? size : 0)};
}

void append_box_edges(Vec3d low, double size, Rgba color, std::vector<OverlayVertex>& out) {
  for (unsigned corner = 0; corner < 8; ++corner) {
    for (unsigned axis = 1; axis < 8; axis *= 2) {
      if ((corner & axis) != 0) continue;
      append_line(corner_of_box(low, size, corner), corner_of_box(low, size, corner | axis), color, out);
    }
  }
}

void append_box_faces(Vec3d low, double size, Rgba color, std::vector<OverlayVertex>& out) {
  constexpr std::array<std::array<unsigned, 3>, 3> kAxes = {{{1, 2, 4}, {2, 4, 1}, {4, 1, 2}}};
  for (const auto& [across, u, v] : kAxes) {
    for (const unsigned side : {0U, across}) {
      for (const unsigned corner : {side, side | u, side | u | v, side, side | u | v, side | v}) {
        out.push_back({vec3_cast<float>(corner_of_box(low, size, corner)), color});
      }
    }
  }
}

struct ShrunkCell {
  Vec3d low;
  double size;
};

ShrunkCell shrunk(const OccupiedCell& cell, double size) {
  const double gap = kShrink * size;
  return {cell.low + Vec3d{gap, gap, gap}, size - 2 * gap};
}

void append_triangle_lines(const DetectionGrid::Corners& corners, Rgba color, std::vector<OverlayVertex>& out) {
  for (std::size_t i = 0; i < 3; ++i) append_line(corners[i], corners[(i + 1) % 3], color, out);
}

void append_contact(const btVector3& place, const btVector3& normal, double length, Rgba color, OverlayGeometry& out) {
  const Vec3d position = to_vec3d(place);
  const double arm = length / 6;
  append_line(position, position + length * to_vec3d(normal), color, out.bright_lines);
  append_line(position - Vec3d{arm, 0, 0}, position + Vec3d{arm, 0, 0}, kWhite, out.bright_lines);
  append_line(position - Vec3d{0, 0, arm}, position + Vec3d{0, 0, arm}, kWhite, out.bright_lines);
}

}  // namespace

Rgba color_of_tests(std::uint64_t tests, std::uint64_t most) {
  return color_of_share(heat(tests, most));
}

void append_cells(const DetectionGrid& grid, OverlayGeometry& out) {
  const auto& cells = grid.cells();
  const auto fullest =
      std::max_element(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.tests < b.tests; });
  for (const OccupiedCell& cell : cells) {
    const Rgba color = color_of_tests(cell.tests, fullest->tests);
    const float part = heat(cell.tests, fullest->tests);
    const ShrunkCell box = shrunk(cell, grid.cell_size());
    append_box_edges(box.low, box.size, faded(color, 0.2F + 0.8F * part), out.lines);
    if (cell.tests > 0) append_box_faces(box.low, box.size, faded(color, kMostFaceOpacity * part), out.triangles);
  }
}

void append_triangle(const DetectionGrid& grid, std::uint32_t triangle, OverlayGeometry& out) {
  const std::vector<DetectionGrid::Corners> children = grid.children_of(triangle);
  for (const DetectionGrid::Corners& child : children) append_triangle_lines(child, kYellow, out.lines);
  if (!children.empty()) return;
  for (const OccupiedCell* cell : grid.cells_of(triangle)) {
    const ShrunkCell box = shrunk(*cell, grid.cell_size());
    append_box_edges(box.low, box.size, kYellow, out.lines);
    append_box_faces(box.low, box.size, faded(kYellow, kFaceOpacity), out.triangles);
  }
}

void append_outline(const btSoftBody& body, int face, OverlayGeometry& out) {
  const auto& nodes = body.m_faces[face].m_n;
  append_triangle_lines({to_vec3d(nodes[0]->m_x), to_vec3d(nodes[1]->m_x), to_vec3d(nodes[2]->m_x)}, kYellow,
                        out.bright_lines);
}

void append_picked_cell(const DetectionGrid& grid, const OccupiedCell& cell, OverlayGeometry& out) {
  append_box_edges(cell.low, grid.cell_size(), kWhite, out.bright_lines);
}

void append_contacts(const std::vector<btSoftBody*>& bodies, OverlayGeometry& out) {
  for (const btSoftBody* body : bodies) {
    const double length = 2 * double(body->getCollisionShape()->getMargin());
    for (int i = 0; i < body->m_scontacts.size(); ++i) {
      const btSoftBody::SContact& contact = body->m_scontacts[i];
      append_contact(contact.m_node->m_x, contact.m_normal, length, kGreen, out);
    }
    for (int i = 0; i < body->m_faceNodeContacts.size(); ++i) {
      const btSoftBody::DeformableFaceNodeContact& contact = body->m_faceNodeContacts[i];
      append_contact(contact.m_node->m_x, contact.m_normal, length, kGreen, out);
    }
  }
}

void append_contacts(const std::vector<bullet::BodyPairContacts>& pairs, ContactColor color, OverlayGeometry& out) {
  for (const bullet::BodyPairContacts& pair : pairs) {
    const auto margin = static_cast<float>(pair.a != nullptr ? pair.a->getCollisionShape()->getMargin() : 0);
    for (const bullet::BodyContact& contact : pair.contacts) {
      const float share = color == ContactColor::depth ? static_cast<float>(contact.depth) / std::max(margin, 1e-6F)
                                                       : 1 - static_cast<float>(contact.time_of_impact);
      append_contact(contact.a.position, contact.normal, 2 * double(margin), color_of_share(share), out);
    }
  }
}

void append_drag(const NodeDrag::Line& line, OverlayGeometry& out) {
  append_line(line.node, line.goal, kWhite, out.bright_lines);
}

}  // namespace softcd::demo

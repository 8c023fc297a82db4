#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "softcd/bullet/body_contacts.hpp"
#include "viewer/detection_grid.hpp"
#include "viewer/node_drag.hpp"
#include "viewer/picking.hpp"

namespace softcd::demo {

/// The meaning of a contact's colour.
enum class ContactColor : std::uint32_t {
  one,             ///< none: all contacts have one colour
  depth,           ///< how much closer two features are than the solver wants them, blue to red
  time_of_impact,  ///< red at the start of the step, blue at its end
};

struct OverlayChoice {
  bool wire = false;      ///< the triangles' edges
  bool cells = false;     ///< occupied cells, coloured by their tests
  bool children = false;  ///< of the picked triangle
  bool contacts = false;
  ContactColor contact_color = ContactColor::one;
  bool picked_cell = false;  ///< the one around the picked triangle's centroid
};

/// A colour on the screen: 8 bits each of red, green, blue and opacity.
using Rgba = std::array<std::uint8_t, 4>;

struct OverlayVertex {
  Vec3f position;
  Rgba color;
};

/// The overlays to draw over the scene.
struct OverlayGeometry {
  std::vector<OverlayVertex> lines;         ///< two each
  std::vector<OverlayVertex> triangles;     ///< three each; may be translucent
  std::vector<OverlayVertex> bright_lines;  ///< two each, thicker
};

/// Returns the colour from blue for the fewest to red for the most tests.
Rgba color_of_tests(std::uint64_t tests, std::uint64_t most);

void append_cells(const DetectionGrid& grid, OverlayGeometry& out);
/// Appends the triangle's children, or the cells in which it is registered where it has none.
void append_triangle(const DetectionGrid& grid, std::uint32_t triangle, OverlayGeometry& out);
void append_outline(const btSoftBody& body, int face, OverlayGeometry& out);
void append_picked_cell(const DetectionGrid& grid, const OccupiedCell& cell, OverlayGeometry& out);
/// Appends a cross at each contact's node, and its normal, twice the body's margin long.
void append_contacts(const std::vector<btSoftBody*>& bodies, OverlayGeometry& out);
/// Appends a cross at each contact's point on the first body, and its normal, in the contact's colour.
void append_contacts(const std::vector<bullet::BodyPairContacts>& pairs, ContactColor color, OverlayGeometry& out);
void append_drag(const NodeDrag::Line& line, OverlayGeometry& out);

}  // namespace softcd::demo

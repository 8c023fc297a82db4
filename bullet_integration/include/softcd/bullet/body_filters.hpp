#pragma once

#include <cstdint>
#include <vector>

#include "softcd/softcd.hpp"
#include "softcd/version.hpp"

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Filters of one soft body's contacts: see WorldDetection::set_filters(). To ignore pairs of whole bodies, use
/// Bullet's setIgnoreCollisionCheck, groups and masks; the deformable world follows them with
/// Settings::filter_deformables.
struct BodyFilters {
  /// One VertexFilter for each node, or none at all. Rigid meshes and convex shapes have the default filter. A node
  /// also passes through what its filter excludes: Detection::ccd does not stop it.
  std::vector<VertexFilter> nodes;
  /// Number of rings of neighbours that have no contact with each other, 1 to 16: see BodySettings::neighbour_rings.
  /// Detection::ccd still stops them, and those within `rest_distance`, from crossing.
  std::uint32_t neighbour_rings = 1;
  /// Features of the body that are at most this far apart when the filters are set have no contact with each other.
  /// Metres; finite and at least 0, which excludes none.
  float rest_distance = 0.0F;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet

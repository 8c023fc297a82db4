#pragma once

#include <cstdint>
#include <vector>

#include "softcd/softcd.hpp"
#include "softcd/version.hpp"

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// What of a soft body is kept from touching: see WorldDetection::set_filters(). (Pairs of bodies are ignored by
/// Bullet's btCollisionObject::setIgnoreCollisionCheck, groups and masks, in the deformable world with
/// Settings::filter_deformables.)
struct BodyFilters {
  /// One for each node, or none; see VertexFilter. Rigid meshes and convex shapes have the default one. What nodes are
  /// kept from they are kept from altogether: Detection::ccd does not prevent them from passing through it.
  std::vector<VertexFilter> nodes;
  /// Within the body: see BodySettings::neighbour_rings. Features that are no contact for that, or because of
  /// `rest_distance`, do not pass through each other with Detection::ccd.
  std::uint32_t neighbour_rings = 1;
  /// Features of the body that are at most so far from each other where its nodes are when the filters are set are no
  /// contact of the body with itself. Finite, at least 0, which excludes none.
  float rest_distance = 0.0F;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet

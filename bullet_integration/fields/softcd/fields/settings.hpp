#pragma once

#include "softcd/bullet/settings.hpp"
#include "softcd/fields/options.hpp"

/// The settings of Bullet's worlds, member by member.
namespace softcd {

template <>
inline constexpr ValueRange kRangeOf<&bullet::Settings::cell_size_factor> = kRangeOf<&QueryOptions::cell_size_factor>;
template <>
inline constexpr ValueRange kRangeOf<&bullet::Settings::untangle_speed> = {.least = 1e-6, .most = 1e6};
template <>
inline constexpr auto kFields<bullet::Settings> = fields_of<
    bullet::Settings, &bullet::Settings::backend, &bullet::Settings::detection, &bullet::Settings::accuracy,
    &bullet::Settings::broad_phase, &bullet::Settings::cell_size_factor, &bullet::Settings::reuse_pairs,
    &bullet::Settings::self_collision, &bullet::Settings::edge_contacts, &bullet::Settings::contacts,
    &bullet::Settings::contacts_per_node, &bullet::Settings::rigid_meshes, &bullet::Settings::convex_shapes,
    &bullet::Settings::untangle, &bullet::Settings::untangle_speed, &bullet::Settings::filter_deformables,
    &bullet::Settings::read_out, &bullet::Settings::on_contacts, &bullet::Settings::on_error, &bullet::Settings::log>();

}  // namespace softcd

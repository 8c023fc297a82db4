#pragma once

#include <array>

#include "softcd/bullet/settings.hpp"
#include "softcd/fields/options.hpp"

/// The settings of Bullet's worlds, member by member.
namespace softcd {

template <>
inline constexpr auto kHelpOf<&bullet::Settings::backend> = kHelpOf<&SceneOptions::backend>;
template <>
inline constexpr auto kHelpOf<&bullet::Settings::detection> =
    "dcd: distances at one end of the step, Bullet's rule; ccd: the whole step, and nodes that would cross a face are "
    "stopped";
template <>
inline constexpr auto kHelpOf<&bullet::Settings::accuracy> = kHelpOf<&QueryOptions::accuracy>;
template <>
inline constexpr auto kHelpOf<&bullet::Settings::broad_phase> = kHelpOf<&QueryOptions::broad_phase>;
template <>
inline constexpr auto kHelpOf<&bullet::Settings::cell_size_factor> = kHelpOf<&QueryOptions::cell_size_factor>;
template <>
inline constexpr ValueRange kRangeOf<&bullet::Settings::cell_size_factor> = kRangeOf<&QueryOptions::cell_size_factor>;
template <>
inline constexpr auto kHelpOf<&bullet::Settings::reuse_pairs> = kHelpOf<&QueryOptions::reuse_pairs>;
template <>
inline constexpr auto kHelpOf<&bullet::Settings::self_collision> =
    "Which bodies collide with themselves: those with setSelfCollision(true), all, or none";
template <>
inline constexpr auto kHelpOf<&bullet::Settings::edge_contacts> =
    "Whether edges touch edges: off, only reported, or given to Bullet's solver (respond). automatic: respond in the "
    "deformable world, off in classic worlds";
template <>
inline constexpr auto kHelpOf<&bullet::Settings::contacts> =
    "The contacts of nodes with faces that Bullet's solver gets. all: Bullet's rule; closest_feature: in classic "
    "worlds one for each place where the surface is nearest. automatic: closest_feature with dcd, otherwise all";
template <>
inline constexpr auto kHelpOf<&bullet::Settings::contacts_per_node> =
    "The most contacts of a node with faces of one body on one side; 0 for no limit";
template <>
inline constexpr auto kHelpOf<&bullet::Settings::rigid_meshes> =
    "Whether softcd detects contacts with rigid triangle meshes";
template <>
inline constexpr auto kHelpOf<&bullet::Settings::convex_shapes> =
    "Which features touch convex rigid shapes: nodes, as in Bullet, or also faces and edges";
template <>
inline constexpr auto kHelpOf<&bullet::Settings::untangle> =
    "Which bodies that intersect are moved apart: none (off), those that did not intersect when both were new (later), "
    "or all. automatic: later, and with dcd those that intersect from the start, except pairs of deformable bodies";
template <>
inline constexpr auto kHelpOf<&bullet::Settings::untangle_speed> =
    "The greatest speed, in metres a second, at which untangle moves a node; 0 chooses by the lengths of edges";
template <>
inline constexpr ValueRange kRangeOf<&bullet::Settings::untangle_speed> = {.least = 0, .most = 1e6};
template <>
inline constexpr auto kHelpOf<&bullet::Settings::filter_deformables> =
    "Deformable world: whether filters apply to pairs of soft bodies, where Bullet ignores them";
template <>
inline constexpr auto kHelpOf<&bullet::Settings::read_out> = "What body_contacts() reports";
template <>
inline constexpr auto kHelpOf<&bullet::Settings::on_error> =
    "When a detection fails: fall_back continues the step with Bullet's own detection; throw_error ends it with an "
    "exception";
template <>
inline constexpr auto kFields<bullet::Settings> = fields_of<
    bullet::Settings, &bullet::Settings::backend, &bullet::Settings::detection, &bullet::Settings::accuracy,
    &bullet::Settings::broad_phase, &bullet::Settings::cell_size_factor, &bullet::Settings::reuse_pairs,
    &bullet::Settings::self_collision, &bullet::Settings::edge_contacts, &bullet::Settings::contacts,
    &bullet::Settings::contacts_per_node, &bullet::Settings::rigid_meshes, &bullet::Settings::convex_shapes,
    &bullet::Settings::untangle, &bullet::Settings::untangle_speed, &bullet::Settings::filter_deformables,
    &bullet::Settings::read_out, &bullet::Settings::on_contacts, &bullet::Settings::on_error, &bullet::Settings::log>();

}  // namespace softcd

namespace softcd::bullet {

/// A function that returns settings to begin with, by its name.
struct Preset {
  const char* name;
  Settings (*value)();
};
inline constexpr std::array<Preset, 3> kPresets = {
    {{"fast", Settings::fast}, {"balanced", Settings::balanced}, {"safe", Settings::safe}}};

}  // namespace softcd::bullet

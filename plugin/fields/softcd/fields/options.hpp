#pragma once

#include "softcd/fields/fields.hpp"
#include "softcd/softcd.hpp"

/// The library's options and results, member by member.
namespace softcd {

template <>
inline constexpr ValueRange kRangeOf<&SceneOptions::cuda_device> = {.least = -1};
template <>
inline constexpr auto kFields<SceneOptions> =
    fields_of<SceneOptions, &SceneOptions::backend, &SceneOptions::memory_limit, &SceneOptions::max_threads,
              &SceneOptions::cuda_device, &SceneOptions::cuda_stream, &SceneOptions::communicator>();

template <>
inline constexpr bool kIsFlattened<Features> = true;
template <>
inline constexpr auto kFields<Features> = fields_of<Features, &Features::vertex_triangle, &Features::edge_edge>();

template <>
inline constexpr ValueRange kRangeOf<&BodySettings::margin> = {.least = 0};
template <>
inline constexpr ValueRange kRangeOf<&BodySettings::neighbour_rings> = {.least = 1, .most = 16};
template <>
inline constexpr ValueRange kRangeOf<&BodySettings::rest_distance> = {.least = 0};
template <>
inline constexpr auto kFields<BodySettings> =
    fields_of<BodySettings, &BodySettings::margin, &BodySettings::filter_group, &BodySettings::filter_mask,
              &BodySettings::self_collision, &BodySettings::kinematic, &BodySettings::features, &BodySettings::batch,
              &BodySettings::neighbour_rings, &BodySettings::rest_distance>();

template <>
inline constexpr ValueRange kRangeOf<&QueryOptions::cell_size_factor> = {.least = 0.1, .most = 100, .or_zero = true};
template <>
inline constexpr ValueRange kRangeOf<&QueryOptions::motion_margin> = {.least = 0};
template <>
inline constexpr bool kMayDifferBetweenRanks<&QueryOptions::reuse_pairs> = true;
template <>
inline constexpr bool kMayDifferBetweenRanks<&QueryOptions::contacts_on_device> = true;
template <>
inline constexpr auto kFields<QueryOptions> = fields_of<
    QueryOptions, &QueryOptions::detection, &QueryOptions::accuracy, &QueryOptions::broad_phase,
    &QueryOptions::subdivision, &QueryOptions::cell_size_factor, &QueryOptions::motion_margin,
    &QueryOptions::contact_rule, &QueryOptions::step_end, &QueryOptions::margins, &QueryOptions::neighbour_filters,
    &QueryOptions::features, &QueryOptions::reuse_pairs, &QueryOptions::contacts_on_device>();

template <>
inline constexpr auto kFields<ProbeOptions> = fields_of<ProbeOptions, &ProbeOptions::step_end>();

template <>
inline constexpr auto kFields<StageTimes> = fields_of<
    StageTimes, &StageTimes::total, &StageTimes::volumes, &StageTimes::subdivision, &StageTimes::assignment,
    &StageTimes::sort, &StageTimes::tests, &StageTimes::features, &StageTimes::narrow, &StageTimes::transfer>();

template <>
inline constexpr auto kFields<Statistics> = fields_of<
    Statistics, &Statistics::backend, &Statistics::bodies, &Statistics::triangles, &Statistics::vertices,
    &Statistics::edges, &Statistics::active_triangles, &Statistics::left_out_triangles, &Statistics::mean_radius,
    &Statistics::cell_size, &Statistics::split_triangles, &Statistics::children, &Statistics::big_triangles,
    &Statistics::entries, &Statistics::cells, &Statistics::tests, &Statistics::reused_pairs,
    &Statistics::looked_up_triangles, &Statistics::triangle_pairs, &Statistics::flagged_pairs,
    &Statistics::vt_candidates, &Statistics::ee_candidates, &Statistics::vt_contacts, &Statistics::ee_contacts,
    &Statistics::unsettled_contacts, &Statistics::earliest_toi, &Statistics::peak_bytes, &Statistics::reruns,
    &Statistics::chunks, &Statistics::ms>();

template <>
inline constexpr auto kFields<StageReport> =
    fields_of<StageReport, &StageReport::stage, &StageReport::ran, &StageReport::reason>();

}  // namespace softcd

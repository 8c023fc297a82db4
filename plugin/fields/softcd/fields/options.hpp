#pragma once

#include "softcd/fields/fields.hpp"
#include "softcd/softcd.h"
#include "softcd/softcd.hpp"

/// The library's options and results, member by member. Options have the same names in softcd.h; a list with a
/// parameter `Options` is for both structs. `kOther` are members that only one of them has.
namespace softcd {

template <>
inline constexpr auto kHelpOf<&SceneOptions::backend> = "The backend; automatic takes a GPU where one exists";
template <>
inline constexpr auto kHelpOf<&SceneOptions::memory_limit> =
    "The most bytes that detections may use; 0 for no limit. Less memory takes more time; too little is an error";
template <>
inline constexpr auto kHelpOf<&SceneOptions::max_threads> =
    "The most threads that work on detections on the CPU; 0 for all processors";
template <>
inline constexpr auto kHelpOf<&SceneOptions::cuda_device> = "The CUDA device, counted from 0; -1 for the current one";
template <>
inline constexpr ValueRange kRangeOf<&SceneOptions::cuda_device> = {.least = -1};
template <class Options, auto... kOther>
inline constexpr auto kSceneOptions =
    fields_of<Options, &Options::backend, &Options::memory_limit, &Options::max_threads, &Options::cuda_device,
              &Options::cuda_stream, kOther...>();
template <>
inline constexpr auto kFields<SceneOptions> = kSceneOptions<SceneOptions, &SceneOptions::communicator>;
template <>
inline constexpr auto kFields<softcd_scene_options> =
    kSceneOptions<softcd_scene_options, &softcd_scene_options::struct_size>;

template <>
inline constexpr bool kIsFlattened<Features> = true;
template <>
inline constexpr auto kHelpOf<&Features::vertex_triangle> = "Whether vertices are tested against triangles";
template <>
inline constexpr auto kHelpOf<&Features::edge_edge> = "Whether edges are tested against edges";
template <>
inline constexpr auto kFields<Features> = fields_of<Features, &Features::vertex_triangle, &Features::edge_edge>();

template <>
inline constexpr auto kHelpOf<&BodySettings::margin> =
    "The surface's margin, in the positions' unit. Two features are in contact when their distance is at most the sum "
    "of both sides' margins: twice this, within one body";
template <>
inline constexpr ValueRange kRangeOf<&BodySettings::margin> = {.least = 0};
template <>
inline constexpr auto kHelpOf<&BodySettings::filter_group> =
    "Bits: two bodies are compared when the mask of each has a bit of the other's group";
template <>
inline constexpr auto kHelpOf<&BodySettings::filter_mask> = "Bits, see filter_group";
template <>
inline constexpr auto kHelpOf<&BodySettings::self_collision> = "Whether the body is compared with itself";
template <>
inline constexpr auto kHelpOf<&BodySettings::kinematic> =
    "Whether the application moves the body. Two such bodies are never compared, nor is one with itself";
template <>
inline constexpr auto kHelpOf<&BodySettings::batch> = "Bodies of different batches never touch";
template <>
inline constexpr auto kHelpOf<&BodySettings::neighbour_rings> =
    "Features of a body that fewer edges than this connect are never in contact; 1 excludes those that share a vertex";
template <>
inline constexpr ValueRange kRangeOf<&BodySettings::neighbour_rings> = {.least = 1, .most = 16};
template <>
inline constexpr auto kHelpOf<&BodySettings::rest_distance> =
    "Features of a body whose distance in the rest positions is at most this are never in contact; 0 excludes none";
template <>
inline constexpr ValueRange kRangeOf<&BodySettings::rest_distance> = {.least = 0};
template <class Settings, auto... kOther>
inline constexpr auto kBodySettings = fields_of<
    Settings, &Settings::margin, &Settings::filter_group, &Settings::filter_mask, &Settings::self_collision,
    &Settings::kinematic, kOther..., &Settings::batch, &Settings::neighbour_rings, &Settings::rest_distance>();
template <>
inline constexpr auto kFields<BodySettings> = kBodySettings<BodySettings, &BodySettings::features>;
template <>
inline constexpr auto kFields<softcd_body_settings> =
    kBodySettings<softcd_body_settings, &softcd_body_settings::struct_size, &softcd_body_settings::vertex_triangle,
                  &softcd_body_settings::edge_edge>;

template <>
inline constexpr auto kHelpOf<&QueryOptions::detection> =
    "dcd: distances at one end of the step; ccd: the straight path from t0 to t1";
template <>
inline constexpr auto kHelpOf<&QueryOptions::accuracy> =
    "The narrow phase's arithmetic. fast: float32; precise: float64; conservative: float64 that finds everything "
    "within a margin. automatic: conservative for positions in double, and for ccd with a margin; else precise";
template <>
inline constexpr auto kHelpOf<&QueryOptions::broad_phase> =
    "How candidate pairs are found: uniform has one grid for the largest triangle, and many more tests";
template <>
inline constexpr auto kHelpOf<&QueryOptions::subdivision> =
    "Virtual subdivision of triangles that are larger than a cell";
template <>
inline constexpr auto kHelpOf<&QueryOptions::cell_size_factor> =
    "The cell size of broad phase exact, in mean bounding radii of the triangles, on the CPU of patches of up to 8 "
    "triangles. 0 chooses";
template <>
inline constexpr ValueRange kRangeOf<&QueryOptions::cell_size_factor> = {.least = 0.1, .most = 100, .or_zero = true};
template <>
inline constexpr auto kHelpOf<&QueryOptions::motion_margin> =
    "dcd only: enlarges a vertex's margin against other bodies by this many times the distance that it moves";
template <>
inline constexpr ValueRange kRangeOf<&QueryOptions::motion_margin> = {.least = 0};
template <>
inline constexpr auto kHelpOf<&QueryOptions::contact_rule> =
    "A vertex's margin is measured from the triangle (distance) or from its plane (slab); its motion margin may count "
    "only towards what lies ahead (ahead)";
template <>
inline constexpr auto kHelpOf<&QueryOptions::step_end> = "The end of the step that dcd uses";
template <>
inline constexpr auto kHelpOf<&QueryOptions::margins> = "Off: all margins count as 0";
template <>
inline constexpr auto kHelpOf<&QueryOptions::neighbour_filters> =
    "Off: neighbour_rings counts as 1 and rest_distance as 0";
template <>
inline constexpr auto kHelpOf<&QueryOptions::reuse_pairs> =
    "Whether found pairs of triangles serve later detections; changes no contacts";
template <>
inline constexpr bool kMayDifferBetweenRanks<&QueryOptions::reuse_pairs> = true;
template <>
inline constexpr auto kHelpOf<&QueryOptions::contacts_on_device> = "Whether contacts stay in the GPU's memory";
template <>
inline constexpr bool kMayDifferBetweenRanks<&QueryOptions::contacts_on_device> = true;
template <class Options, auto... kOther>
inline constexpr auto kQueryOptions = fields_of<
    Options, &Options::detection, &Options::accuracy, &Options::broad_phase, &Options::subdivision,
    &Options::cell_size_factor, &Options::motion_margin, &Options::contact_rule, &Options::step_end, &Options::margins,
    &Options::neighbour_filters, kOther..., &Options::reuse_pairs, &Options::contacts_on_device>();
template <>
inline constexpr auto kFields<QueryOptions> = kQueryOptions<QueryOptions, &QueryOptions::features>;
template <>
inline constexpr auto kFields<softcd_query_options> =
    kQueryOptions<softcd_query_options, &softcd_query_options::struct_size, &softcd_query_options::vertex_triangle,
                  &softcd_query_options::edge_edge>;

template <>
inline constexpr auto kFields<ProbeOptions> = fields_of<ProbeOptions, &ProbeOptions::step_end>();

template <>
inline constexpr auto kFields<StageTimes> = fields_of<
    StageTimes, &StageTimes::total, &StageTimes::volumes, &StageTimes::subdivision, &StageTimes::assignment,
    &StageTimes::sort, &StageTimes::tests, &StageTimes::features, &StageTimes::narrow, &StageTimes::transfer>();

// kTime has the detection's time: that of every stage in C++, the total in C.
template <class Struct, auto kTime, auto... kOther>
inline constexpr auto kStatistics = fields_of<
    Struct, &Struct::backend, &Struct::bodies, &Struct::triangles, &Struct::vertices, &Struct::edges,
    &Struct::active_triangles, &Struct::left_out_triangles, kOther..., &Struct::triangle_pairs, &Struct::vt_candidates,
    &Struct::ee_candidates, &Struct::vt_contacts, &Struct::ee_contacts, &Struct::unsettled_contacts,
    &Struct::earliest_toi, &Struct::peak_bytes, &Struct::reruns, &Struct::chunks, kTime>();
template <>
inline constexpr auto kFields<Statistics> =
    kStatistics<Statistics, &Statistics::ms, &Statistics::mean_radius, &Statistics::cell_size,
                &Statistics::split_triangles, &Statistics::children, &Statistics::big_triangles, &Statistics::entries,
                &Statistics::cells, &Statistics::tests, &Statistics::reused_pairs, &Statistics::looked_up_triangles,
                &Statistics::flagged_pairs>;
template <>
inline constexpr auto kFields<softcd_statistics> =
    kStatistics<softcd_statistics, &softcd_statistics::total_ms, &softcd_statistics::struct_size>;

template <>
inline constexpr auto kFields<StageReport> =
    fields_of<StageReport, &StageReport::stage, &StageReport::ran, &StageReport::reason>();

}  // namespace softcd

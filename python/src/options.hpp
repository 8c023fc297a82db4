#pragma once

#include "fields.hpp"
#include "softcd/softcd.hpp"

/// What Python's keyword arguments are called, and where their values go.
namespace softcd::python {

inline constexpr auto kSceneOptions = fields_of<SceneOptions>(
    Field{"backend", &SceneOptions::backend}, Field{"memory_limit", &SceneOptions::memory_limit},
    Field{"max_threads", &SceneOptions::max_threads}, Field{"cuda_device", &SceneOptions::cuda_device});

inline constexpr auto kBodySettings = fields_of<BodySettings>(
    Field{"margin", &BodySettings::margin}, Field{"self_collision", &BodySettings::self_collision},
    Field{"vertex_triangle", [](BodySettings& s) -> bool& { return s.features.vertex_triangle; }},
    Field{"edge_edge", [](BodySettings& s) -> bool& { return s.features.edge_edge; }},
    Field{"kinematic", &BodySettings::kinematic}, Field{"filter_group", &BodySettings::filter_group},
    Field{"filter_mask", &BodySettings::filter_mask}, Field{"batch", &BodySettings::batch},
    Field{"neighbour_rings", &BodySettings::neighbour_rings}, Field{"rest_distance", &BodySettings::rest_distance});

inline constexpr auto kQueryOptions = fields_of<QueryOptions>(
    Field{"detection", &QueryOptions::detection}, Field{"accuracy", &QueryOptions::accuracy},
    Field{"contact_rule", &QueryOptions::contact_rule}, Field{"step_end", &QueryOptions::step_end},
    Field{"margins", &QueryOptions::margins}, Field{"motion_margin", &QueryOptions::motion_margin},
    Field{"vertex_triangle", [](QueryOptions& o) -> bool& { return o.features.vertex_triangle; }},
    Field{"edge_edge", [](QueryOptions& o) -> bool& { return o.features.edge_edge; }},
    Field{"broad_phase", &QueryOptions::broad_phase}, Field{"subdivision", &QueryOptions::subdivision},
    Field{"lambda_", &QueryOptions::lambda}, Field{"reuse_pairs", &QueryOptions::reuse_pairs},
    Field{"contacts_on_device", &QueryOptions::contacts_on_device},
    Field{"neighbour_filters", &QueryOptions::neighbour_filters});

}  // namespace softcd::python

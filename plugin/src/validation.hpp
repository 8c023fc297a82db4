#pragma once

#include "body.hpp"
#include "softcd/error.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/probe.hpp"
#include "softcd/query.hpp"

/// Checks of the caller's arguments. Each throws InvalidInput, naming the wrong value and the allowed ones.
namespace softcd {

constexpr std::uint64_t kMostElements = 1ULL << 31;  ///< triangles, vertices or edges in one pipeline

void validate_options(const SceneOptions& options);
void validate_options(const QueryOptions& options);
void validate_options(const ProbeOptions& options);
void validate_settings(BodyId id, const BodySettings& settings);
/// Also checks the settings.
void validate_mesh(BodyId id, const BodyDesc& desc);
/// Also checks the settings. `before` is the body's present mesh: see Scene::update_body.
void validate_change(BodyId id, const BodyDesc& desc, Span<const std::uint32_t> changed, const ChangingMesh& before);
void validate_positions(BodyId id, std::uint32_t vertex_count, const Positions& x_t0, const Positions& x_t1);
void validate_vertex_filters(BodyId id, std::uint32_t vertex_count, Span<const VertexFilter> filters);
void validate_rest_positions(BodyId id, std::uint32_t vertex_count, const Positions& x);

/// Checks that positions on a device are on the reader's device, unless the body already uses this memory.
void validate_on_device(const Body& body, const Positions& x_t0, const Positions& x_t1, DevicePositionReader& reader);

}  // namespace softcd

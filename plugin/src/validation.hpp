#pragma once

#include "body.hpp"
#include "softcd/error.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/probe.hpp"
#include "softcd/query.hpp"

/// Checks of what the caller gives. Each throws InvalidInput that names what is wrong and what would be right.
namespace softcd {

constexpr std::uint64_t kMostElements = 1ULL << 31;  ///< triangles, vertices or edges in one pipeline

void validate_options(const SceneOptions& options);
void validate_options(const QueryOptions& options);
void validate_options(const ProbeOptions& options);
void validate_settings(BodyId id, const BodySettings& settings);
/// And the settings.
void validate_mesh(BodyId id, const BodyDesc& desc);
/// And the settings, of a body that is `before`: see Scene::update_body.
void validate_change(BodyId id, const BodyDesc& desc, Span<const std::uint32_t> changed, const ChangingMesh& before);
void validate_positions(BodyId id, std::uint32_t vertex_count, const Positions& x_t0, const Positions& x_t1);
void validate_vertex_filters(BodyId id, std::uint32_t vertex_count, Span<const VertexFilter> filters);
void validate_rest_positions(BodyId id, std::uint32_t vertex_count, const Positions& x);

/// Positions on a device: that it is the reader's, unless the body has had them where they are.
void validate_on_device(const Body& body, const Positions& x_t0, const Positions& x_t1, DevicePositionReader& reader);

}  // namespace softcd

#include "validation.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "body_positions.hpp"
#include "softcd/fields/options.hpp"

namespace softcd {
namespace {

template <class Struct>
void validate_fields(const Struct& object) {
  const std::string problem = problem_of(object);
  if (!problem.empty()) throw InvalidInput(problem + ".");
}

void validate_end(BodyId id, std::uint32_t vertex_count, const Positions& positions, const char* when) {
  const std::size_t size = position_size(positions);
  const std::size_t alignment = size / 3;
  if (positions.count() != vertex_count) {
    throw InvalidInput(fmt::format("body {}: {} positions were given for {}, but the body has {} vertices.", id.value,
                                   positions.count(), when, vertex_count));
  }
  if (positions.count() > 0 && positions.data() == nullptr) {
    throw InvalidInput(fmt::format("body {}: the pointer to its positions for {} is null.", id.value, when));
  }
  if (positions.count() > 1 && positions.stride() < size) {
    throw InvalidInput(
        fmt::format("body {}: the stride of its positions for {} is {} bytes, but a position is {} bytes long.",
                    id.value, when, positions.stride(), size));
  }
  const bool is_misplaced = reinterpret_cast<std::uintptr_t>(positions.data()) % alignment != 0;
  if (is_misplaced || (positions.count() > 1 && positions.stride() % alignment != 0)) {
    throw InvalidInput(fmt::format(
        "body {}: its positions for {} are misaligned; their address and their stride, {} bytes, must be multiples "
        "of the {} bytes of a coordinate.",
        id.value, when, positions.stride(), alignment));
  }
}

template <std::size_t kCount>
void validate_indices(BodyId id, const BodyDesc& desc, const char* what, std::size_t place,
                      const std::uint32_t (&vertices)[kCount]) {
  for (const std::uint32_t v : vertices) {
    if (v < desc.vertex_count) continue;
    throw InvalidInput(
        fmt::format("body {}: {} {} has vertex index {}, but the body has {} vertices; indices count from 0.", id.value,
                    what, place, v, desc.vertex_count));
  }
}

void validate_triangle(BodyId id, const BodyDesc& desc, std::size_t t) {
  validate_indices(id, desc, "triangle", t, desc.triangles[t].v);
}

void validate_size(BodyId id, const BodyDesc& desc) {
  if (desc.triangles.size() + desc.segments.size() < kMostElements && desc.vertex_count < kMostElements) return;
  throw InvalidInput(
      fmt::format("body {}: {} triangles, {} segments and {} vertices are more than 2^31; split the bodies over "
                  "several scenes.",
                  id.value, desc.triangles.size(), desc.segments.size(), desc.vertex_count));
}

}  // namespace

void validate_options(const SceneOptions& options) {
  validate_fields(options);
}

void validate_options(const QueryOptions& options) {
  validate_fields(options);
  if (options.motion_margin > 0.0F && options.detection == Detection::dcd && options.step_end == StepEnd::t0) {
    throw InvalidInput("motion_margin is for the end of a step; set it to 0, or step_end to t1.");
  }
}

void validate_options(const ProbeOptions& options) {
  validate_fields(options);
}

void validate_settings(BodyId id, const BodySettings& settings) {
  const std::string problem = problem_of(settings);
  if (!problem.empty()) throw InvalidInput(fmt::format("body {}: its {}.", id.value, problem));
}

void validate_mesh(BodyId id, const BodyDesc& desc) {
  validate_size(id, desc);
  for (std::size_t t = 0; t < desc.triangles.size(); ++t) validate_triangle(id, desc, t);
  for (std::size_t s = 0; s < desc.segments.size(); ++s) validate_indices(id, desc, "segment", s, desc.segments[s].v);
  validate_settings(id, desc.settings);
}

void validate_change(BodyId id, const BodyDesc& desc, Span<const std::uint32_t> changed, const ChangingMesh& before) {
  validate_size(id, desc);
  const Topology& mesh = before.topology();
  for (const std::uint32_t t : changed) {
    if (t >= desc.triangles.size()) {
      throw InvalidInput(
          fmt::format("body {}: triangle {} is said to have changed, but there are {} triangles; indices count from 0.",
                      id.value, t, desc.triangles.size()));
    }
    validate_triangle(id, desc, t);
  }
  for (std::size_t t = mesh.triangles.size(); t < desc.triangles.size(); ++t) validate_triangle(id, desc, t);
  std::vector<std::uint32_t> sorted;
  if (desc.vertex_count < mesh.vertex_count) sorted.assign(changed.begin(), changed.end());
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t v = desc.vertex_count; v < mesh.vertex_count; ++v) {
    before.for_each_triangle_of(v, [&](std::uint32_t t) {
      if (t >= desc.triangles.size() || std::binary_search(sorted.begin(), sorted.end(), t)) return;
      throw InvalidInput(
          fmt::format("body {}: triangle {} has not changed, and has vertex index {}, but the body has {} vertices; "
                      "indices count from 0.",
                      id.value, t, v, desc.vertex_count));
    });
  }
  validate_settings(id, desc.settings);
}

void validate_positions(BodyId id, std::uint32_t vertex_count, const Positions& x_t0, const Positions& x_t1) {
  validate_end(id, vertex_count, x_t1, "t1");  // first: positions of one end only are those at t1
  validate_end(id, vertex_count, x_t0, "t0");
  if (x_t0.is_double() != x_t1.is_double()) {
    throw InvalidInput(fmt::format(
        "body {}: its positions at t0 and t1 are of different types; give both as float or both as double.", id.value));
  }
  if (x_t0.is_on_device() != x_t1.is_on_device()) {
    throw InvalidInput(fmt::format(
        "body {}: its positions are at one end in the host's memory, at the other in a device's; give both in one.",
        id.value));
  }
}

void validate_vertex_filters(BodyId id, std::uint32_t vertex_count, Span<const VertexFilter> filters) {
  if (filters.empty() || filters.size() == vertex_count) return;
  throw InvalidInput(fmt::format("body {}: {} vertex filters were given, but the body has {} vertices.", id.value,
                                 filters.size(), vertex_count));
}

void validate_rest_positions(BodyId id, std::uint32_t vertex_count, const Positions& x) {
  validate_end(id, vertex_count, x, "rest");
  if (x.is_on_device()) {
    throw InvalidInput(
        fmt::format("body {}: its rest positions are in a device's memory; give them in the host's.", id.value));
  }
  for (std::size_t v = 0; v < x.count(); ++v) {
    const Vec3d position = x.is_double() ? position_at<double>(given(x), v) : position_at<float>(given(x), v);
    if (is_usable(position)) continue;
    throw InvalidInput(
        fmt::format("body {}: vertex {} of its rest positions is not finite, or beyond 1e37.", id.value, v));
  }
}

void validate_on_device(const Body& body, const Positions& x_t0, const Positions& x_t1, DevicePositionReader& reader) {
  const auto validate = [&](const Positions& x, const Positions& before, const char* when) {
    const bool is_known = before.is_on_device() && before.data() == x.data();
    if (is_known || x.count() == 0 || reader.can_read(x.data())) return;
    throw InvalidInput(
        fmt::format("body {}: its positions for {} are not in the memory of CUDA device {}, which the scene uses; copy "
                    "them there, or "
                    "give positions in the host's memory.",
                    body.id.value, when, reader.device()));
  };
  validate(x_t0, body.positions.given_t0(), "t0");
  validate(x_t1, body.positions.given_t1(), "t1");
}

}  // namespace softcd

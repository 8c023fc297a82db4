#include <string>

#include "c_fields.hpp"

namespace softcd::c_interface {
namespace {

BodyDesc body_desc(const uint32_t* triangles, uint64_t triangle_count, uint32_t vertex_count,
                   const softcd_body_settings* settings) {
  return {rows<Triangle>(triangles, triangle_count, "triangles"), vertex_count,
          from_c<BodySettings>(settings, "settings")};
}

BodyDesc body_desc(const softcd_mesh* mesh, const softcd_body_settings* settings) {
  const softcd_mesh& read = sized(mesh, "mesh");
  BodyDesc desc = body_desc(read.triangles, read.triangle_count, read.vertex_count, settings);
  desc.segments = rows<Segment>(read.segments, read.segment_count, "segments");
  return desc;
}

template <class Scalar>
Positions positions_of(const softcd_positions& given) {
  const auto* const first_x = static_cast<const Scalar*>(given.data);
  const auto count = static_cast<std::size_t>(given.count);
  const auto stride = static_cast<std::size_t>(given.stride);
  switch (given.memory) {
    case SOFTCD_HOST:
      return {first_x, count, stride};
    case SOFTCD_CUDA_DEVICE:
      return Positions::on_device(first_x, count, stride, given.ready);
    default:
      refuse_choice("memory", given.memory, SOFTCD_CUDA_DEVICE);
  }
}

Positions read_positions(const softcd_positions* given, const char* argument) {
  const softcd_positions& read = sized(given, argument);
  switch (read.scalar) {
    case SOFTCD_FLOAT32:
      return positions_of<float>(read);
    case SOFTCD_FLOAT64:
      return positions_of<double>(read);
    default:
      refuse_choice("scalar", read.scalar, SOFTCD_FLOAT64);
  }
}

}  // namespace
}  // namespace softcd::c_interface

namespace c = softcd::c_interface;

softcd_status softcd_scene_options_init(softcd_scene_options* options, uint64_t size) {
  return c::initialize(options, size, "options", c::to_c<softcd_scene_options>(softcd::SceneOptions()));
}

softcd_status softcd_scene_create(const softcd_scene_options* options, softcd_scene** scene) {
  return c::guarded_call([&] {
    softcd_scene*& out = c::result(scene, "scene");
    out = new softcd_scene{softcd::Scene(c::from_c<softcd::SceneOptions>(options, "options"))};
  });
}

void softcd_scene_destroy(softcd_scene* scene) {
  delete scene;
}

softcd_status softcd_scene_set_options(softcd_scene* scene, const softcd_scene_options* options) {
  return c::guarded_call(
      [&] { c::required(scene, "scene").scene.set_options(c::from_c<softcd::SceneOptions>(options, "options")); });
}

softcd_status softcd_scene_backend(const softcd_scene* scene, softcd_backend* backend) {
  return c::guarded_call([&] {
    softcd_backend& out = c::result(backend, "backend");
    out = static_cast<softcd_backend>(c::required(scene, "scene").scene.backend());
  });
}

softcd_status softcd_scene_set_log(softcd_scene* scene, softcd_log log, void* user_data) {
  return c::guarded_call([&] {
    softcd::LogCallback callback;
    if (log != nullptr) {
      callback = [log, user_data](softcd::LogLevel level, std::string_view text) {
        log(user_data, static_cast<softcd_log_level>(level), std::string(text).c_str());
      };
    }
    c::required(scene, "scene").scene.set_log(std::move(callback));
  });
}

softcd_status softcd_body_settings_init(softcd_body_settings* settings, uint64_t size) {
  return c::initialize(settings, size, "settings", c::to_c<softcd_body_settings>(softcd::BodySettings()));
}

softcd_status softcd_scene_add_body(softcd_scene* scene, const uint32_t* triangles, uint64_t triangle_count,
                                    uint32_t vertex_count, const softcd_body_settings* settings, softcd_body* body) {
  return c::guarded_call([&] {
    softcd_body& out = c::result(body, "body") = SOFTCD_NO_BODY;
    const softcd::BodyDesc desc = c::body_desc(triangles, triangle_count, vertex_count, settings);
    out = c::required(scene, "scene").scene.add_body(desc).value;
  });
}

softcd_status softcd_scene_update_body(softcd_scene* scene, softcd_body body, const uint32_t* triangles,
                                       uint64_t triangle_count, uint32_t vertex_count,
                                       const softcd_body_settings* settings) {
  return c::guarded_call([&] {
    const softcd::BodyDesc desc = c::body_desc(triangles, triangle_count, vertex_count, settings);
    c::required(scene, "scene").scene.update_body({body}, desc);
  });
}

softcd_status softcd_scene_add_mesh(softcd_scene* scene, const softcd_mesh* mesh, const softcd_body_settings* settings,
                                    softcd_body* body) {
  return c::guarded_call([&] {
    softcd_body& out = c::result(body, "body") = SOFTCD_NO_BODY;
    const softcd::BodyDesc desc = c::body_desc(mesh, settings);
    out = c::required(scene, "scene").scene.add_body(desc).value;
  });
}

softcd_status softcd_scene_update_mesh(softcd_scene* scene, softcd_body body, const softcd_mesh* mesh,
                                       const softcd_body_settings* settings, const uint32_t* changed,
                                       uint64_t changed_count) {
  return c::guarded_call([&] {
    const softcd::BodyDesc desc = c::body_desc(mesh, settings);
    softcd::Scene& updated = c::required(scene, "scene").scene;
    const auto indices = c::elements<std::uint32_t>(changed, changed_count, "changed");
    if (changed == nullptr) {
      updated.update_body({body}, desc);
    } else {
      updated.update_body({body}, desc, indices);
    }
  });
}

softcd_status softcd_scene_set_settings(softcd_scene* scene, softcd_body body, const softcd_body_settings* settings) {
  return c::guarded_call([&] {
    c::required(scene, "scene").scene.set_settings({body}, c::from_c<softcd::BodySettings>(settings, "settings"));
  });
}

softcd_status softcd_scene_remove_body(softcd_scene* scene, softcd_body body) {
  return c::guarded_call([&] { c::required(scene, "scene").scene.remove_body({body}); });
}

softcd_status softcd_scene_has_body(const softcd_scene* scene, softcd_body body, uint32_t* has_body) {
  return c::guarded_call([&] {
    uint32_t& out = c::result(has_body, "has_body");
    out = c::required(scene, "scene").scene.has_body({body}) ? 1 : 0;
  });
}

softcd_status softcd_scene_set_positions(softcd_scene* scene, softcd_body body, const softcd_positions* x_t0,
                                         const softcd_positions* x_t1) {
  return c::guarded_call([&] {
    softcd::Scene& changed = c::required(scene, "scene").scene;
    const softcd::Positions end = c::read_positions(x_t1, "x_t1");
    if (x_t0 == nullptr) {
      changed.set_positions({body}, end);
    } else {
      changed.set_positions({body}, c::read_positions(x_t0, "x_t0"), end);
    }
  });
}

softcd_status softcd_scene_set_ignored_pairs(softcd_scene* scene, const softcd_body_pair* pairs, uint64_t count) {
  return c::guarded_call([&] {
    c::required(scene, "scene").scene.set_ignored_pairs(c::elements<softcd::BodyPair>(pairs, count, "pairs"));
  });
}

softcd_status softcd_scene_set_vertex_filters(softcd_scene* scene, softcd_body body,
                                              const softcd_vertex_filter* filters, uint64_t count) {
  return c::guarded_call([&] {
    c::required(scene, "scene")
        .scene.set_vertex_filters({body}, c::elements<softcd::VertexFilter>(filters, count, "filters"));
  });
}

softcd_status softcd_scene_set_rest_positions(softcd_scene* scene, softcd_body body, const softcd_positions* x) {
  return c::guarded_call([&] {
    c::required(scene, "scene")
        .scene.set_rest_positions({body}, x != nullptr ? c::read_positions(x, "x") : softcd::Positions());
  });
}

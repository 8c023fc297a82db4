#include "viewer/surface_renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "scenes/surface_normals.hpp"
#include "viewer/look.hpp"
#include "viewer/pins.hpp"

namespace softcd::demo {
namespace {

constexpr int kShadowSize = 1024;

constexpr const char* kSurfaceVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 front;
layout(location = 3) in vec3 back;
layout(location = 4) in float has_edges_drawn;
uniform mat4 view_projection;
out vec3 world_position, world_normal, front_color, back_color, weights;
out float edges;
void main() {
  world_position = position;
  world_normal = normal;
  front_color = front;
  back_color = back;
  edges = has_edges_drawn;
  weights = vec3(gl_VertexID % 3 == 0, gl_VertexID % 3 == 1, gl_VertexID % 3 == 2);
  gl_Position = view_projection * vec4(position, 1);
}
)";

constexpr const char* kDepthVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 light;
void main() { gl_Position = light * vec4(position, 1); }
)";

constexpr const char* kDepthFragmentShader = "#version 330 core\nvoid main() {}\n";

// A triangle that covers the screen.
constexpr const char* kBackgroundVertexShader = R"(#version 330 core
layout(location = 0) in vec2 place;
out vec2 on_screen;
void main() {
  on_screen = place;
  gl_Position = vec4(place, 0, 1);
}
)";

// Lighting: sky light that is stronger from above, the sun where nothing blocks it, and its gloss. The sun is a disk,
// so the width of a shadow's edge depends on the distance of the object that casts it (percentage-closer soft shadows,
// Fernando 2005). The samples lie on a spiral that covers a disk evenly (Vogel 1979). All pixels use the same spiral:
// turning it from pixel to pixel would hide its steps in noise, which picture formats compress badly.
constexpr const char* kShading = R"(
uniform vec3 eye;
uniform mat4 light;
uniform vec3 light_size;  // of the shadow map's box, in the scene's unit
uniform sampler2DShadow shadows;
uniform sampler2D shadow_depths;

vec2 spiral(int i, int count) {
  float angle = 2.39996323 * i;
  return sqrt((i + 0.5) / count) * vec2(cos(angle), sin(angle));
}

// A surface that leans away from the sun rises towards it within the disk.
float lit_part(vec3 position, float towards_sun) {
  vec3 place = 0.5 * (light * vec4(position, 1)).xyz + 0.5;
  vec2 outside = (abs(place.xy - 0.5) - 0.5) * light_size.xy;
  if (max(outside.x, outside.y) > kWidestShadowEdge) return 1.0;
  float slope = min(sqrt(max(0, 1 - towards_sun * towards_sun)) / towards_sun, kSteepestSlope);
  float blockers = 0;
  float way = 0;  // from them to here, in the scene's unit, summed up
  for (int i = 0; i < kBlockerSamples; ++i) {
    vec2 offset = kWidestShadowEdge * spiral(i, kBlockerSamples);
    float depth = texture(shadow_depths, place.xy + offset / light_size.xy).x;
    float in_front = (place.z - depth) * light_size.z - kShadowBias - length(offset) * slope;
    if (in_front > 0) {
      blockers += 1;
      way += in_front;
    }
  }
  if (blockers == 0) return 1.0;
  float radius = clamp(kSunRadius * way / blockers, kSharpestShadowEdge, kWidestShadowEdge);
  float bias = (kShadowBias + radius * slope) / light_size.z;
  float lit = 0;
  for (int i = 0; i < kShadowSamples; ++i) {
    lit += texture(shadows, vec3(place.xy + radius * spiral(i, kShadowSamples) / light_size.xy, place.z - bias));
  }
  return lit / kShadowSamples;
}

vec3 shade(vec3 position, vec3 normal, vec3 color) {
  float towards_sun = max(0, dot(normal, kToSun));
  float sun = towards_sun > 0 ? towards_sun * lit_part(position, towards_sun) : 0;
  vec3 half_way = normalize(kToSun + normalize(eye - position));
  float gloss = sun > 0 ? kGloss * pow(max(0, dot(normal, half_way)), kGlossExponent) : 0;
  float sky = kAmbient * (0.75 + 0.25 * normal.y);
  return (sky + kSun * sun) * color + vec3(gloss);
}

vec4 on_display(vec3 linear) { return vec4(pow(clamp(linear, 0.0, 1.0), vec3(1 / kGamma)), 1); }
)";

constexpr const char* kSurfaceFragmentShader = R"(
in vec3 world_position, world_normal, front_color, back_color, weights;
in float edges;
uniform float wire;
out vec4 color;

// Returns the share of an edge at this point; an edge is half a line wide on either side.
float at_edge() {
  vec3 pixels = weights / fwidth(weights);
  return 1 - smoothstep(0.4 * kEdgeWidth, 0.6 * kEdgeWidth + 0.5, min(min(pixels.x, pixels.y), pixels.z));
}

void main() {
  vec3 normal = normalize(world_normal);
  if (!gl_FrontFacing) normal = -normal;
  vec3 paint = gl_FrontFacing ? front_color : back_color;
  paint *= mix(1, kEdgeShade, max(edges, wire) * at_edge());
  color = on_display(shade(world_position, normal, paint));
}
)";

// Draws both floor and sky. The mean of the checks over a pixel is a product of two square waves of period 2, one in
// each direction, whose integral is a triangle wave.
constexpr const char* kBackgroundFragmentShader = R"(
in vec2 on_screen;
uniform mat4 view_projection;
uniform vec3 right, up, back;  // right and up as long as half of the screen at distance 1
uniform float floor_height;
out vec4 color;

vec2 integral(vec2 x) { return abs(mod(x, 2) - 1); }

float dark_part(vec2 place) {
  vec2 width = max(fwidth(place), 1e-4);
  vec2 wave = (integral(place + 0.5 * width) - integral(place - 0.5 * width)) / width;
  return 0.5 - 0.5 * wave.x * wave.y;
}

void main() {
  vec3 ray = normalize(on_screen.x * right + on_screen.y * up - back);
  float to_floor = ray.y < 0 ? (floor_height - eye.y) / ray.y : kFloorReach;
  vec3 position = eye + to_floor * ray;
  vec3 floor_color = mix(kFloorLight, kFloorDark, dark_part(position.xz));
  if (to_floor < 0 || to_floor >= kFloorReach) {
    color = on_display(mix(kHorizon, kZenith, clamp(ray.y * 1.6, 0.0, 1.0)));
    gl_FragDepth = 1;
    return;
  }
  float haze = to_floor / kFloorReach;
  color = on_display(mix(shade(position, vec3(0, 1, 0), floor_color), kHorizon, haze * haze));
  vec4 clip = view_projection * vec4(position, 1);
  gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
}
)";

std::string constant(const char* name, Vec3d v) {
  return fmt::format("const vec3 {} = vec3({:f}, {:f}, {:f});\n", name, v.x, v.y, v.z);
}
std::string constant(const char* name, double value) {
  return fmt::format("const float {} = {:f};\n", name, value);
}

std::string constant(const char* name, int value) {
  return fmt::format("const int {} = {};\n", name, value);
}

std::string with_shading(const char* fragment_shader) {
  std::string source = "#version 330 core\n";
  source += constant("kToSun", unit(kTowardsSun)) + constant("kAmbient", kAmbient) + constant("kSun", kSun);
  source += constant("kGloss", kGloss) + constant("kGlossExponent", kGlossExponent);
  source += constant("kShadowBias", kShadowBias) + constant("kSunRadius", kSunRadius);
  source += constant("kSharpestShadowEdge", kSharpestShadowEdge) + constant("kWidestShadowEdge", kWidestShadowEdge);
  source += constant("kSteepestSlope", kSteepestSlope);
  source += constant("kBlockerSamples", kBlockerSamples) + constant("kShadowSamples", kShadowSamples);
  source += constant("kEdgeWidth", kEdgeWidth) + constant("kEdgeShade", kEdgeShade);
  source += constant("kFloorReach", kFloorReach) + constant("kGamma", static_cast<double>(kGamma));
  source +=
      constant("kFloorLight", vec3_cast<double>(kFloorLight)) + constant("kFloorDark", vec3_cast<double>(kFloorDark));
  source += constant("kHorizon", vec3_cast<double>(kHorizon)) + constant("kZenith", vec3_cast<double>(kZenith));
  return source + kShading + fragment_shader;
}

Vec3f to_vec3f(const Color& color) {
  return {color.red, color.green, color.blue};
}

bool is_finite(const btVector3& v) {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

Vec3d in_frame(const ViewFrame& frame, Vec3f point) {
  const Vec3d p = vec3_cast<double>(point);
  return {dot(p, frame.right), dot(p, frame.up), dot(p, frame.back)};
}

}  // namespace

SurfaceRenderer::SurfaceRenderer()
    : surface_program_(kSurfaceVertexShader, with_shading(kSurfaceFragmentShader)),
      background_program_(kBackgroundVertexShader, with_shading(kBackgroundFragmentShader)),
      depth_program_(kDepthVertexShader, kDepthFragmentShader),
      mesh_(sizeof(Vertex), {{3, GL_FLOAT, offsetof(Vertex, position)},
                             {3, GL_FLOAT, offsetof(Vertex, normal)},
                             {3, GL_FLOAT, offsetof(Vertex, front)},
                             {3, GL_FLOAT, offsetof(Vertex, back)},
                             {1, GL_FLOAT, offsetof(Vertex, has_edges_drawn)}}),
      screen_(2 * sizeof(float), {{2, GL_FLOAT, 0}}),
      shadows_(kShadowSize) {
  screen_.upload(std::vector<std::array<float, 2>>{{-1, -1}, {3, -1}, {-1, 3}});
}

void SurfaceRenderer::append(const Surface& surface) {
  const std::vector<Vec3d> normals = smooth_normals(*surface.body);
  for (int f = 0; f < surface.body->m_faces.size(); ++f) {
    const auto& nodes = surface.body->m_faces[f].m_n;
    if (!std::all_of(std::begin(nodes), std::end(nodes), [](const auto* n) { return is_finite(n->m_x); })) continue;
    for (const btSoftBody::Node* node : nodes) {
      const Vec3d normal = unit(normals[static_cast<std::size_t>(node - &surface.body->m_nodes[0])]);
      vertices_.push_back({vec3_cast<float>(to_vec3d(node->m_x)), vec3_cast<float>(normal), to_vec3f(surface.front),
                           to_vec3f(surface.back), surface.has_edges_drawn ? 1.0F : 0.0F});
    }
  }
}

void SurfaceRenderer::append_pins(const btSoftBody& body) {
  constexpr Vec3f kMetal = {0.25F, 0.25F, 0.27F};
  for (const PinCorner& corner : pins_of(body)) {
    vertices_.push_back({corner.position, corner.normal, kMetal, kMetal, 0.0F});
  }
}

void SurfaceRenderer::update(const Scene& scene) {
  vertices_.clear();
  for (const Surface& surface : scene.all_surfaces()) {
    append(surface);
    append_pins(*surface.body);
  }
  mesh_.upload(vertices_);
  floor_height_ = double(scene.view().floor_height);

  // The light's box contains the scene, and reaches down to the last shadow on the floor.
  const ViewFrame frame = looking_along(-kTowardsSun);
  constexpr double kFar = std::numeric_limits<double>::max();
  Vec3d low = {kFar, kFar, kFar};
  Vec3d high = -low;
  double highest = floor_height_;
  for (const Vertex& vertex : vertices_) {
    const Vec3d p = in_frame(frame, vertex.position);
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    highest = std::max(highest, static_cast<double>(vertex.position.y));
  }
  if (low.x > high.x) low = high = Vec3d{0, 0, 0};
  low = low - Vec3d{0.1, 0.1, (highest - floor_height_) / unit(kTowardsSun).y + 0.1};
  high = high + Vec3d{0.1, 0.1, 0.1};
  light_ = orthographic(frame, low, high);
  light_size_ = high - low;
}

void SurfaceRenderer::draw_shadows() const {
  const GLuint before = shadows_.begin_drawing();
  depth_program_.use();
  depth_program_.set("light", light_);
  mesh_.draw(GL_TRIANGLES);
  shadows_.end_drawing(before);
}

void SurfaceRenderer::draw(const OrbitCamera& camera, const Viewport& viewport, bool wire) const {
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);  // the sky has the greatest depth
  glDisable(GL_BLEND);
  draw_shadows();
  glViewport(viewport.left, 0, viewport.width, viewport.height);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  shadows_.bind();

  const double aspect = viewport.aspect();
  const Matrix4 view_projection = camera.view_projection(aspect);
  for (const GlProgram* program : {&surface_program_, &background_program_}) {
    program->use();
    program->set("view_projection", view_projection);
    program->set("eye", camera.eye());
    program->set("light", light_);
    program->set("light_size", light_size_);
    program->set("shadows", 0);
    program->set("shadow_depths", 1);
  }
  surface_program_.use();
  surface_program_.set("wire", wire ? 1.0 : 0.0);
  mesh_.draw(GL_TRIANGLES);

  background_program_.use();
  const double half_height = std::tan(camera.field_of_view() / 2);
  const ViewFrame frame = camera.frame();
  background_program_.set("right", half_height * aspect * frame.right);
  background_program_.set("up", half_height * frame.up);
  background_program_.set("back", frame.back);
  background_program_.set("floor_height", floor_height_);
  screen_.draw(GL_TRIANGLES);
}

}  // namespace softcd::demo

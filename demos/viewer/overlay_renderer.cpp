#include "viewer/overlay_renderer.hpp"

#include <cstddef>

namespace softcd::demo {
namespace {

constexpr const char* kVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 color;
uniform mat4 view_projection;
uniform vec3 eye;
uniform float nearer;  // part of the way to the eye, by which lines are lifted off the surfaces that they lie in
out vec4 vertex_color;
void main() {
  vertex_color = color;
  gl_Position = view_projection * vec4(mix(position, eye, nearer), 1);
}
)";

constexpr const char* kFragmentShader = R"(#version 330 core
in vec4 vertex_color;
out vec4 color;
void main() { color = vertex_color; }
)";

const std::vector<GlMesh::Attribute> kAttributes = {{3, GL_FLOAT, offsetof(OverlayVertex, position)},
                                                    {4, GL_UNSIGNED_BYTE, offsetof(OverlayVertex, color)}};

}  // namespace

OverlayRenderer::OverlayRenderer()
    : program_(kVertexShader, kFragmentShader),
      lines_(sizeof(OverlayVertex), kAttributes),
      triangles_(sizeof(OverlayVertex), kAttributes),
      bright_lines_(sizeof(OverlayVertex), kAttributes) {}

void OverlayRenderer::update(const OverlayGeometry& geometry) {
  lines_.upload(geometry.lines);
  triangles_.upload(geometry.triangles);
  bright_lines_.upload(geometry.bright_lines);
}

void OverlayRenderer::draw(const OrbitCamera& camera, double aspect) const {
  program_.use();
  program_.set("view_projection", camera.view_projection(aspect));
  program_.set("eye", camera.eye());
  program_.set("nearer", 0.0);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  triangles_.draw(GL_TRIANGLES);
  glDepthMask(GL_TRUE);
  glLineWidth(1);
  program_.set("nearer", 1e-3);
  lines_.draw(GL_LINES);
  glLineWidth(2);
  program_.set("nearer", 5e-3);
  bright_lines_.draw(GL_LINES);
  glDisable(GL_BLEND);
}

}  // namespace softcd::demo

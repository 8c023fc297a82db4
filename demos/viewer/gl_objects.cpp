#include "viewer/gl_objects.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace softcd::demo {
namespace {

GLuint compile(GLenum kind, const std::string& source) {
  const GLuint shader = glCreateShader(kind);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint is_compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &is_compiled);
  if (is_compiled == GL_TRUE) return shader;
  std::array<char, 1024> message{};
  glGetShaderInfoLog(shader, static_cast<GLsizei>(message.size()), nullptr, message.data());
  throw std::runtime_error(std::string("a shader of the viewer does not compile: ") + message.data());
}

}  // namespace

GlProgram::GlProgram(const std::string& vertex_shader, const std::string& fragment_shader) : id_(glCreateProgram()) {
  for (const GLuint shader : {compile(GL_VERTEX_SHADER, vertex_shader), compile(GL_FRAGMENT_SHADER, fragment_shader)}) {
    glAttachShader(id_, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(id_);
  GLint is_linked = GL_FALSE;
  glGetProgramiv(id_, GL_LINK_STATUS, &is_linked);
  if (is_linked != GL_TRUE) throw std::runtime_error("the viewer's shaders do not link");
}

GlProgram::~GlProgram() {
  glDeleteProgram(id_);
}

void GlProgram::set(const char* name, const Matrix4& value) const {
  glUniformMatrix4fv(glGetUniformLocation(id_, name), 1, GL_FALSE, value.data());
}

void GlProgram::set(const char* name, Vec3d value) const {
  const Vec3f v = vec3_cast<float>(value);
  glUniform3f(glGetUniformLocation(id_, name), v.x, v.y, v.z);
}

void GlProgram::set(const char* name, double value) const {
  glUniform1f(glGetUniformLocation(id_, name), static_cast<float>(value));
}

void GlProgram::set(const char* name, int value) const {
  glUniform1i(glGetUniformLocation(id_, name), value);
}

GlMesh::GlMesh(std::size_t stride, const std::vector<Attribute>& attributes) {
  glGenVertexArrays(1, &array_);
  glGenBuffers(1, &buffer_);
  glBindVertexArray(array_);
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  for (GLuint i = 0; i < attributes.size(); ++i) {
    const Attribute& attribute = attributes[i];
    glEnableVertexAttribArray(i);
    glVertexAttribPointer(i, attribute.count, attribute.type, GL_TRUE, static_cast<GLsizei>(stride),
                          // NOLINTNEXTLINE(performance-no-int-to-ptr): OpenGL's way to pass an offset
                          reinterpret_cast<const void*>(attribute.offset));
  }
}

GlMesh::~GlMesh() {
  glDeleteBuffers(1, &buffer_);
  glDeleteVertexArrays(1, &array_);
}

void GlMesh::upload(const void* vertices, std::size_t count, std::size_t size) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(count * size), vertices, GL_STREAM_DRAW);
  count_ = static_cast<GLsizei>(count);
}

void GlMesh::draw(GLenum mode) const {
  if (count_ == 0) return;
  glBindVertexArray(array_);
  glDrawArrays(mode, 0, count_);
}

Image read_pixels(int width, int height) {
  const auto row = 3 * static_cast<std::size_t>(width);
  const auto rows = static_cast<std::size_t>(height);
  std::vector<std::uint8_t> upside_down(row * rows);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, upside_down.data());
  Image image{width, height, std::vector<std::uint8_t>(upside_down.size())};
  for (std::size_t y = 0; y < rows; ++y) {
    std::copy_n(upside_down.data() + y * row, row, image.rgb.data() + (rows - 1 - y) * row);
  }
  return image;
}

GlCanvas::GlCanvas(int width, int height) : width_(width), height_(height) {
  constexpr GLsizei kSamples = 4;
  glGenFramebuffers(1, &pixels_);
  glGenFramebuffers(1, &samples_);
  glGenRenderbuffers(static_cast<GLsizei>(renderbuffers_.size()), renderbuffers_.data());
  const auto attach = [&](std::size_t buffer, GLsizei samples, GLenum format, GLenum attachment) {
    glBindRenderbuffer(GL_RENDERBUFFER, renderbuffers_[buffer]);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, renderbuffers_[buffer]);
  };
  glBindFramebuffer(GL_FRAMEBUFFER, pixels_);
  attach(2, 0, GL_RGBA8, GL_COLOR_ATTACHMENT0);
  glBindFramebuffer(GL_FRAMEBUFFER, samples_);
  attach(0, kSamples, GL_RGBA8, GL_COLOR_ATTACHMENT0);
  attach(1, kSamples, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw std::runtime_error("OpenGL cannot draw pictures of " + std::to_string(width) + " x " +
                             std::to_string(height) + " pixels");
  }
}

GlCanvas::~GlCanvas() {
  glDeleteFramebuffers(1, &samples_);
  glDeleteFramebuffers(1, &pixels_);
  glDeleteRenderbuffers(static_cast<GLsizei>(renderbuffers_.size()), renderbuffers_.data());
}

Image GlCanvas::read() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, samples_);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, pixels_);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, pixels_);
  return read_pixels(width_, height_);
}

GlDepthMap::GlDepthMap(int size) : size_(size) {
  glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, size, size, 0, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  const GLfloat furthest[] = {1, 1, 1, 1};
  glTexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, furthest);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);

  glGenSamplers(1, &reader_);
  glSamplerParameteri(reader_, GL_TEXTURE_COMPARE_MODE, GL_NONE);
  glSamplerParameteri(reader_, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glSamplerParameteri(reader_, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glSamplerParameteri(reader_, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  glSamplerParameteri(reader_, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  glSamplerParameterfv(reader_, GL_TEXTURE_BORDER_COLOR, furthest);

  glGenFramebuffers(1, &framebuffer_);
  const GLuint before = begin_drawing();
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture_, 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  end_drawing(before);
}

GlDepthMap::~GlDepthMap() {
  glDeleteFramebuffers(1, &framebuffer_);
  glDeleteSamplers(1, &reader_);
  glDeleteTextures(1, &texture_);
}

GLuint GlDepthMap::begin_drawing() const {
  GLint before = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &before);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, size_, size_);
  glClear(GL_DEPTH_BUFFER_BIT);
  return static_cast<GLuint>(before);
}

void GlDepthMap::end_drawing(GLuint framebuffer_before) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_before);
}

void GlDepthMap::bind() const {
  for (GLuint unit = 0; unit < 2; ++unit) {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glBindSampler(unit, unit == 0 ? 0 : reader_);
  }
  glActiveTexture(GL_TEXTURE0);
}

}  // namespace softcd::demo

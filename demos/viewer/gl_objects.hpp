#pragma once

#include <epoxy/gl.h>

#include <array>
#include <string>
#include <vector>

#include "viewer/camera.hpp"
#include "viewer/image.hpp"

namespace softcd::demo {

/// A linked pair of shaders. All classes here need a current OpenGL 3.3 context for their whole life.
class GlProgram {
 public:
  /// Throws std::runtime_error with the compiler's message.
  GlProgram(const std::string& vertex_shader, const std::string& fragment_shader);
  ~GlProgram();
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  void use() const { glUseProgram(id_); }
  // After use() only:
  void set(const char* name, const Matrix4& value) const;
  void set(const char* name, Vec3d value) const;
  void set(const char* name, double value) const;
  void set(const char* name, int value) const;

 private:
  GLuint id_;
};

/// Vertices that are uploaded again whenever they change.
class GlMesh {
 public:
  struct Attribute {
    GLint count;
    GLenum type;  ///< bytes become 0 to 1
    std::size_t offset;
  };

  GlMesh(std::size_t stride, const std::vector<Attribute>& attributes);
  ~GlMesh();
  GlMesh(const GlMesh&) = delete;
  GlMesh& operator=(const GlMesh&) = delete;

  template <class Vertex>
  void upload(const std::vector<Vertex>& vertices) {
    upload(vertices.data(), vertices.size(), sizeof(Vertex));
  }
  void draw(GLenum mode) const;

 private:
  void upload(const void* vertices, std::size_t count, std::size_t size);

  GLuint array_ = 0;
  GLuint buffer_ = 0;
  GLsizei count_ = 0;
};

/// Returns the content of the framebuffer that is bound for reading.
Image read_pixels(int width, int height);

/// A framebuffer to draw into instead of a window, with 4 samples a pixel.
class GlCanvas {
 public:
  /// Throws std::runtime_error where OpenGL cannot draw pictures of that size.
  GlCanvas(int width, int height);
  ~GlCanvas();
  GlCanvas(const GlCanvas&) = delete;
  GlCanvas& operator=(const GlCanvas&) = delete;

  /// Directs later draws into the canvas.
  void bind() const { glBindFramebuffer(GL_FRAMEBUFFER, samples_); }
  Image read() const;

 private:
  int width_, height_;
  GLuint samples_ = 0, pixels_ = 0;        ///< framebuffers
  std::array<GLuint, 3> renderbuffers_{};  ///< colours and depths of the samples, colours of the pixels
};

/// A square depth texture to draw into, and to compare with or to read afterwards.
class GlDepthMap {
 public:
  explicit GlDepthMap(int size);
  ~GlDepthMap();
  GlDepthMap(const GlDepthMap&) = delete;
  GlDepthMap& operator=(const GlDepthMap&) = delete;

  /// Clears the map and directs later draws into it, until end_drawing(), which takes the returned value.
  GLuint begin_drawing() const;
  void end_drawing(GLuint framebuffer_before) const;
  /// Binds the map to texture unit 0 for comparisons, and to unit 1 for depths.
  void bind() const;

 private:
  int size_;
  GLuint texture_ = 0;
  GLuint framebuffer_ = 0;
  GLuint reader_ = 0;  ///< a sampler that does not compare
};

}  // namespace softcd::demo

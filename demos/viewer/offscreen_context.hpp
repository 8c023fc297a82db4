#pragma once

namespace softcd::demo {

/// An OpenGL 3.3 context without a window, which is current while it lives. EGL's devices are tried in turn: GPUs, and
/// Mesa's renderer on the CPU, so that neither a display nor a GPU is needed. One at a time.
class OffscreenContext {
 public:
  /// Throws std::runtime_error where no device has such a context.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

 private:
  bool make_current(void* device);

  void* display_ = nullptr;  ///< an EGLDisplay
  void* context_ = nullptr;  ///< an EGLContext
};

}  // namespace softcd::demo

#pragma once

namespace softcd::demo {

/// An OpenGL 3.3 context without a window, current for the lifetime of this object. It tries EGL's devices in turn:
/// GPUs, and Mesa's renderer on the CPU. So it needs neither a display nor a GPU. Only one may exist at a time.
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

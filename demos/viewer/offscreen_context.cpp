#include "viewer/offscreen_context.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace softcd::demo {
namespace {

[[noreturn]] void refuse(const char* reason) {
  throw std::runtime_error(std::string("no pictures can be drawn: ") + reason +
                           "; libgl1-mesa-dri and libegl-mesa0 draw without a GPU");
}

// libepoxy, which calls OpenGL, ends the program where there is no OpenGL.
bool has_opengl() {
  return dlopen("libOpenGL.so.0", RTLD_LAZY) != nullptr || dlopen("libGL.so.1", RTLD_LAZY) != nullptr;
}

}  // namespace

OffscreenContext::OffscreenContext() {
  if (!has_opengl()) refuse("there is no OpenGL library");
  const auto query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  std::array<EGLDeviceEXT, 32> devices{};
  EGLint count = 0;
  if (query_devices == nullptr ||
      query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count) != EGL_TRUE) {
    refuse("EGL knows no devices");
  }
  if (!std::any_of(devices.begin(), devices.begin() + count, [this](EGLDeviceEXT d) { return make_current(d); })) {
    refuse("no device of EGL's has OpenGL 3.3");
  }
}

bool OffscreenContext::make_current(EGLDeviceEXT device) {
  const auto get_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (get_display == nullptr) return false;
  display_ = get_display(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
  if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) != EGL_TRUE) return false;

  const std::array<EGLint, 5> wanted = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
  const std::array<EGLint, 7> version = {
      EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  if (eglBindAPI(EGL_OPENGL_API) == EGL_TRUE &&
      eglChooseConfig(display_, wanted.data(), &config, 1, &configs) == EGL_TRUE && configs > 0) {
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, version.data());
    if (context_ == EGL_NO_CONTEXT) return false;
    if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE) return true;
    eglDestroyContext(display_, context_);
  }
  return false;
}

// The display is not closed. There is one display for a device, whoever requests it, and Mesa's drivers leak memory
// when they are unloaded.
OffscreenContext::~OffscreenContext() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

}  // namespace softcd::demo

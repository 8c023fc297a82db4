#pragma once

#include <cstdint>
#include <string>
#include <vector>

struct GLFWwindow;

namespace softcd::demo {

/// A window with an OpenGL 3.3 context, current for the lifetime of this object, and a frame of Dear ImGui at a time.
/// Only one may exist at a time, on the main thread.
class Window {
 public:
  /// Throws std::runtime_error when there is no display or no such OpenGL.
  explicit Window(const std::string& title);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool is_closing() const;
  void close();
  /// Return the size in pixels.
  int width() const { return width_; }
  int height() const { return height_; }

  void begin_frame();
  /// Returns GLFW's codes of the keys that were pressed since the frame before.
  const std::vector<int>& pressed_keys() const { return pressed_keys_; }
  /// Draws Dear ImGui's windows over the content so far.
  void draw_panels();
  void end_frame();

 private:
  GLFWwindow* window_ = nullptr;
  int width_ = 0;
  int height_ = 0;
  std::vector<int> pressed_keys_;
};

}  // namespace softcd::demo

#include "viewer/window.hpp"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <stdexcept>

#define GLFW_INCLUDE_NONE  // NOLINT(readability-identifier-naming): GLFW's
#include <GLFW/glfw3.h>

namespace softcd::demo {
namespace {

constexpr int kWidth = 1280;
constexpr int kHeight = 800;
constexpr int kSamples = 4;

std::string last_problem() {
  const char* problem = nullptr;
  glfwGetError(&problem);
  return problem == nullptr ? "no reason given" : problem;
}

}  // namespace

Window::Window(const std::string& title) {
  if (glfwInit() != GLFW_TRUE) {
    throw std::runtime_error(fmt::format("no window can be opened: {}; is there a display?", last_problem()));
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_SAMPLES, kSamples);
  window_ = glfwCreateWindow(kWidth, kHeight, title.c_str(), nullptr, nullptr);
  if (window_ == nullptr) {
    const std::string problem = last_problem();
    glfwTerminate();
    throw std::runtime_error(fmt::format("no window can be opened: {}; the viewer needs OpenGL 3.3", problem));
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  // Set before Dear ImGui's own callbacks, which call the callbacks that were set before them.
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int /*scancode*/, int action, int /*modifiers*/) {
    if (action == GLFW_RELEASE) return;
    static_cast<Window*>(glfwGetWindowUserPointer(window))->pressed_keys_.push_back(key);
  });
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui_ImplGlfw_InitForOpenGL(window_, /*install_callbacks=*/true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

bool Window::is_closing() const {
  return glfwWindowShouldClose(window_) == GLFW_TRUE;
}

void Window::close() {
  glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

void Window::begin_frame() {
  pressed_keys_.clear();
  glfwPollEvents();
  glfwGetFramebufferSize(window_, &width_, &height_);
  // Zero while the window is an icon.
  width_ = std::max(width_, 1);
  height_ = std::max(height_, 1);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void Window::draw_panels() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Window::end_frame() {
  glfwSwapBuffers(window_);
}

}  // namespace softcd::demo

#include "viewer/viewer.hpp"

#include <imgui.h>

#include <cmath>
#include <exception>
#include <memory>
#include <optional>
#include <utility>

#include "viewer/node_drag.hpp"
#include "viewer/overlay_renderer.hpp"
#include "viewer/panel.hpp"
#include "viewer/session.hpp"
#include "viewer/surface_renderer.hpp"
#include "viewer/window.hpp"

#define GLFW_INCLUDE_NONE  // NOLINT(readability-identifier-naming): GLFW's
#include <GLFW/glfw3.h>

namespace softcd::demo {
namespace {

constexpr double kRadiansPerPixel = 0.006;
constexpr double kZoomPerNotch = 0.9;
constexpr btScalar kThrowRate = btScalar(1.5);   // distances from eye to scene per second, of a thrown ball
constexpr btScalar kBallShare = btScalar(0.04);  // its radius, of that distance

class Viewer {
 public:
  Viewer(const std::string& scene_name, const SceneOptions& scene_options, const ViewerOptions& options)
      : options_(options),
        session_(scene_name, scene_options),
        window_("softcd: " + scene_name),
        camera_(session_.scene().view()) {
    panel_.overlays = options.overlays;
  }

  void run() {
    for (long frame = 1; !window_.is_closing(); ++frame) {
      const bool is_last = frame == options_.frames;
      window_.begin_frame();
      take_keys();
      take_mouse();
      advance();
      draw();
      save_picture();
      if (is_last) {
        if (options_.take_screenshot) options_.take_screenshot(read_pixels(window_.width(), window_.height()));
        window_.close();
      }
      window_.end_frame();
    }
  }

 private:
  void take_keys() {
    for (const int key : window_.pressed_keys()) {
      if (key == GLFW_KEY_SPACE) panel_.is_paused = !panel_.is_paused;
      if (key == GLFW_KEY_RIGHT) panel_.step_once = panel_.is_paused = true;
      if (key == GLFW_KEY_R) panel_.restart = true;
      if (key == GLFW_KEY_V) panel_.reset_view = true;
      if (key == GLFW_KEY_B) panel_.throw_ball = true;
      if (key == GLFW_KEY_P) panel_.save_picture = true;
      if (key == GLFW_KEY_H) panel_.is_visible = !panel_.is_visible;
      if (key == GLFW_KEY_ESCAPE) window_.close();
    }
  }

  /// Returns the part of the window that the panel leaves free.
  Viewport viewport() const {
    const int left = panel_.is_visible && window_.width() > 2 * kPanelWidth ? kPanelWidth : 0;
    return {left, window_.width() - left, window_.height()};
  }

  Ray cursor_ray() const {
    const ImGuiIO& io = ImGui::GetIO();
    const Viewport view = viewport();
    const double x = 2 * (static_cast<double>(io.MousePos.x) - view.left) / view.width - 1;
    const double y = 1 - 2 * static_cast<double>(io.MousePos.y) / view.height;
    return camera_.ray_through(x, y, view.aspect());
  }

  void take_mouse() {
    const ImGuiIO& io = ImGui::GetIO();
    if (!io.WantCaptureMouse) {
      if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.KeyShift) press();
      if (ImGui::IsMouseReleased(ImGuiMouseButton_Left)) pick();
      move_view(io);
    }
    if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) drag_.release();
    drag_.follow(cursor_ray());
  }

  void press() {
    const std::optional<PickedFace> face = pick_face(session_.bodies(), cursor_ray());
    if (!face) return;
    const int node = nearest_free_node(*session_.bodies()[face->body], *face);
    if (node >= 0) drag_.take(session_.bodies(), face->body, node, camera_, cursor_ray());
  }

  // Picks a face where the mouse was pressed and released in one place.
  void pick() {
    const ImVec2 way = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left);
    if (way.x != 0 || way.y != 0) return;
    const std::optional<PickedFace> face = pick_face(session_.bodies(), cursor_ray());
    panel_.selected.reset();
    if (face) panel_.selected = SelectedFace{face->body, face->face};
  }

  void move_view(const ImGuiIO& io) {
    const double x = static_cast<double>(io.MouseDelta.x);
    const double y = static_cast<double>(io.MouseDelta.y);
    const bool is_left = ImGui::IsMouseDown(ImGuiMouseButton_Left) && !drag_.is_active();
    const bool is_right = ImGui::IsMouseDown(ImGuiMouseButton_Right);
    if (ImGui::IsMouseDown(ImGuiMouseButton_Middle) || ((is_left || is_right) && io.KeyShift)) {
      const Viewport view = viewport();
      camera_.pan(2 * x / view.width, -2 * y / view.height, view.aspect());
    } else if (is_left || is_right) {
      camera_.orbit(x * kRadiansPerPixel, y * kRadiansPerPixel);
    }
    if (io.MouseWheel != 0) camera_.zoom(std::pow(kZoomPerNotch, static_cast<double>(io.MouseWheel)));
  }

  /// Carries out the requests of panel and keys, and the frame's steps.
  void advance() {
    if (std::exchange(panel_.reset_view, false)) camera_ = OrbitCamera(session_.scene().view());
    if (std::exchange(panel_.restart, false)) restart();
    if (panel_.go_on_with) go_on_with(*std::exchange(panel_.go_on_with, std::nullopt));
    if (panel_.open_scene) open(*std::exchange(panel_.open_scene, std::nullopt));
    if (std::exchange(panel_.throw_ball, false)) throw_ball();
    const int steps = std::exchange(panel_.step_once, false) ? 1 : panel_.is_paused ? 0 : panel_.steps_per_frame;
    for (int i = 0; i < steps; ++i) {
      drag_.pull(session_.bodies());
      session_.step();
    }
    if (steps > 0) has_changed_ = true;
  }

  void restart() {
    session_.restart();
    forget_bodies();
  }

  void open(const std::string& scene_name) {
    try {
      session_.open(scene_name);
      camera_ = OrbitCamera(session_.scene().view());
      panel_.problem.clear();
      forget_bodies();
    } catch (const std::exception& error) {
      panel_.problem = error.what();
    }
  }

  /// Forgets references to bodies, because the bodies have changed.
  void forget_bodies() {
    drag_.release();
    panel_.selected.reset();
    panel_.penetrating.reset();
    has_changed_ = true;
  }

  /// Throws a ball from near the eye in the direction of the view.
  void throw_ball() {
    const View view = session_.scene().view();
    const btScalar distance = view.eye.distance(view.target);
    const Ray ray = camera_.ray_through(0, 0, viewport().aspect());
    const Vec3d start = ray.origin + (0.3 * double(distance)) * ray.direction;
    const btScalar speed = kThrowRate * distance;
    const btVector3 direction(btScalar(ray.direction.x), btScalar(ray.direction.y), btScalar(ray.direction.z));
    session_.throw_ball(btVector3(btScalar(start.x), btScalar(start.y), btScalar(start.z)), kBallShare * distance,
                        speed * direction);
    has_changed_ = true;
  }

  void save_picture() {
    if (!options_.save_picture || !std::exchange(panel_.save_picture, false)) return;
    try {
      panel_.saved_picture = options_.save_picture(read_pixels(window_.width(), window_.height()));
    } catch (const std::exception& error) {
      panel_.problem = error.what();
    }
  }

  void go_on_with(const SceneOptions& scene_options) {
    try {
      session_.go_on_with(scene_options);
      panel_.problem.clear();
    } catch (const std::exception& error) {
      panel_.problem = error.what();
    }
    has_changed_ = true;
  }

  void draw() {
    if (std::exchange(has_changed_, false)) {
      surface_renderer_.update(session_.scene());
      grid_.reset();
    }
    update_overlays();
    const Viewport view = viewport();
    surface_renderer_.draw(camera_, view, panel_.overlays.wire);
    overlay_renderer_.draw(camera_, view.aspect());
    if (panel_.is_visible) draw_panel(session_, grid_.get(), panel_);
    window_.draw_panels();
  }

  void update_overlays() {
    const OverlayChoice& choice = panel_.overlays;
    const bool needs_grid = choice.cells || choice.children || choice.picked_cell || panel_.selected;
    if (needs_grid && grid_ == nullptr) grid_ = session_.make_grid();
    OverlayGeometry geometry;
    const bool has_colors = choice.contacts && choice.contact_color != ContactColor::one &&
                            session_.scene().simulation().detection() != nullptr;
    session_.set_reads_contacts(has_colors);
    if (has_colors) {
      append_contacts(session_.body_contacts(), choice.contact_color, geometry);
    } else if (choice.contacts) {
      append_contacts(session_.bodies(), geometry);
    }
    if (choice.cells && grid_ != nullptr) append_cells(*grid_, geometry);
    if (panel_.selected) append_selection(geometry);
    if (drag_.is_active()) append_drag(drag_.line(session_.bodies()), geometry);
    overlay_renderer_.update(geometry);
  }

  void append_selection(OverlayGeometry& geometry) const {
    const SelectedFace& selected = *panel_.selected;
    append_outline(*session_.bodies()[selected.body], selected.face, geometry);
    if (grid_ == nullptr) return;
    const std::uint32_t triangle = grid_->first_triangle(selected.body) + static_cast<std::uint32_t>(selected.face);
    if (panel_.overlays.children) append_triangle(*grid_, triangle, geometry);
    const OccupiedCell* cell = grid_->cell_around(triangle);
    if (panel_.overlays.picked_cell && cell != nullptr) append_picked_cell(*grid_, *cell, geometry);
  }

  const ViewerOptions& options_;
  Session session_;
  Window window_;
  OrbitCamera camera_;
  SurfaceRenderer surface_renderer_;
  OverlayRenderer overlay_renderer_;
  NodeDrag drag_;
  PanelState panel_;
  std::unique_ptr<DetectionGrid> grid_;  ///< while it is shown
  bool has_changed_ = true;              ///< since the last drawing
};

}  // namespace

void run_viewer(const std::string& scene_name, const SceneOptions& scene_options, const ViewerOptions& options) {
  Viewer(scene_name, scene_options, options).run();
}

}  // namespace softcd::demo

// Functions that the page calls. They run a session of the viewer, its camera, and the node that the mouse holds.

#include <emscripten/emscripten.h>

#include <array>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/surface_normals.hpp"
#include "viewer/node_drag.hpp"
#include "viewer/picking.hpp"
#include "viewer/pins.hpp"
#include "viewer/session.hpp"

namespace softcd::demo {
namespace {

/// A scene of the page, in a size that a browser's one thread steps smoothly.
struct PageScene {
  const char* name;
  int size;
};

constexpr std::array<PageScene, 9> kScenes = {{{"cloth-on-ball", 40},
                                               {"reef-knot", 150},
                                               {"bowline", 240},
                                               {"funnel", 30},
                                               {"flamenco", 12},
                                               {"n-body", 12},
                                               {"stack", 16},
                                               {"tube", 30},
                                               {"tearing", 30}}};

/// Triangles in one pair of colours, as the page reads them from memory.
struct Part {
  std::uint32_t first_vertex, vertex_count;
  Color front, back;
};

/// One of the detectors of contacts between soft bodies.
struct Detector {
  Collision collision;
  bullet::Settings (*settings)();  ///< of softcd
};

/// In the order of the page's buttons.
constexpr std::array<Detector, 4> kDetectors = {{{Collision::softcd, bullet::Settings::balanced},
                                                 {Collision::softcd, bullet::Settings::safe},
                                                 {Collision::bullet, bullet::Settings::balanced},
                                                 {Collision::off, bullet::Settings::balanced}}};

constexpr Color kPinColor{0.9F, 0.6F, 0.1F};

/// The page's scene, and what is drawn of it.
class Page {
 public:
  Page(const PageScene& scene, const Detector& detector)
      : session_(scene.name, options_of(scene, detector)), camera_(session_.scene().view()) {
    read_surfaces();
  }

  Session& session() { return session_; }
  OrbitCamera& camera() { return camera_; }
  const std::vector<PinCorner>& vertices() const { return vertices_; }
  const std::vector<Part>& parts() const { return parts_; }

  void use(const Detector& detector) {
    SceneOptions options = session_.options();
    options.collision = detector.collision;
    options.settings = detector.settings();
    session_.go_on_with(options);
  }

  void step() {
    drag_.pull(session_.bodies());
    session_.step();
    read_surfaces();
  }

  bool press(const Ray& cursor) {
    const std::optional<PickedFace> face = pick_face(session_.bodies(), cursor);
    const int node = face ? nearest_free_node(*session_.bodies()[face->body], *face) : -1;
    if (node < 0) return false;
    drag_.take(session_.bodies(), face->body, node, camera_, cursor);
    return true;
  }
  void follow(const Ray& cursor) { drag_.follow(cursor); }
  void release() { drag_.release(); }

 private:
  static SceneOptions options_of(const PageScene& scene, const Detector& detector) {
    SceneOptions options;
    options.collision = detector.collision;
    options.settings = detector.settings();
    options.size = scene.size;
    return options;
  }

  void read_surfaces() {
    vertices_.clear();
    parts_.clear();
    for (const Surface& surface : session_.scene().all_surfaces()) {
      const std::vector<Vec3d> normals = smooth_normals(*surface.body);
      const auto first = static_cast<std::uint32_t>(vertices_.size());
      const btSoftBody::Node* const nodes = &surface.body->m_nodes[0];
      for (int i = 0; i < surface.body->m_faces.size(); ++i) {
        for (const btSoftBody::Node* node : surface.body->m_faces[i].m_n) {
          const Vec3d normal = unit(normals[static_cast<std::size_t>(node - nodes)]);
          vertices_.push_back({{node->m_x.x(), node->m_x.y(), node->m_x.z()}, to_float(normal)});
        }
      }
      add_part(first, surface.front, surface.back);
    }
    const auto first = static_cast<std::uint32_t>(vertices_.size());
    for (const btSoftBody* body : session_.bodies()) {
      const std::vector<PinCorner> pins = pins_of(*body);
      vertices_.insert(vertices_.end(), pins.begin(), pins.end());
    }
    add_part(first, kPinColor, kPinColor);
  }

  static Vec3f to_float(Vec3d v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }

  void add_part(std::uint32_t first, const Color& front, const Color& back) {
    parts_.push_back({first, static_cast<std::uint32_t>(vertices_.size()) - first, front, back});
  }

  Session session_;
  OrbitCamera camera_;
  NodeDrag drag_;
  std::vector<PinCorner> vertices_;
  std::vector<Part> parts_;
};

std::unique_ptr<Page> page;
std::string problem;

/// Returns the text of the exception that f throws, else an empty text.
template <class F>
const char* problem_of(const F& f) {
  problem.clear();
  try {
    f();
  } catch (const std::exception& error) {
    problem = error.what();
  }
  return problem.c_str();
}

}  // namespace

extern "C" {

EMSCRIPTEN_KEEPALIVE int page_scene_count() {
  return static_cast<int>(kScenes.size());
}
EMSCRIPTEN_KEEPALIVE const char* page_scene_name(int scene) {
  return kScenes[static_cast<std::size_t>(scene)].name;
}
EMSCRIPTEN_KEEPALIVE const char* page_scene_description(int scene) {
  return find_scene(page_scene_name(scene))->description;
}

// These three functions return the error's text, or an empty text. `detector` is an index of kDetectors.
EMSCRIPTEN_KEEPALIVE const char* page_open(std::size_t scene, std::size_t detector) {
  return problem_of([&] { page = std::make_unique<Page>(kScenes.at(scene), kDetectors.at(detector)); });
}
EMSCRIPTEN_KEEPALIVE const char* page_use(std::size_t detector) {
  return problem_of([&] { page->use(kDetectors.at(detector)); });
}
EMSCRIPTEN_KEEPALIVE const char* page_step() {
  return problem_of([&] { page->step(); });
}

EMSCRIPTEN_KEEPALIVE float page_step_ms() {
  return page->session().step_ms().last();
}
EMSCRIPTEN_KEEPALIVE int page_contacts() {
  return static_cast<int>(page->session().scene().count_contacts());
}
EMSCRIPTEN_KEEPALIVE int page_crossings() {
  return static_cast<int>(page->session().scene().count_penetration().edges);
}
EMSCRIPTEN_KEEPALIVE int page_triangles() {
  return static_cast<int>(page->session().scene().count_triangles());
}

EMSCRIPTEN_KEEPALIVE int page_vertex_count() {
  return static_cast<int>(page->vertices().size());
}
EMSCRIPTEN_KEEPALIVE const PinCorner* page_vertices() {
  return page->vertices().data();
}
EMSCRIPTEN_KEEPALIVE int page_part_count() {
  return static_cast<int>(page->parts().size());
}
EMSCRIPTEN_KEEPALIVE const Part* page_parts() {
  return page->parts().data();
}
/// Returns a matrix column by column, then the eye's position and the floor's height.
EMSCRIPTEN_KEEPALIVE const float* page_view(double aspect) {
  static std::array<float, 20> view;
  const Matrix4 matrix = page->camera().view_projection(aspect);
  const Vec3d eye = page->camera().eye();
  std::copy(matrix.begin(), matrix.end(), view.begin());
  view[16] = static_cast<float>(eye.x);
  view[17] = static_cast<float>(eye.y);
  view[18] = static_cast<float>(eye.z);
  view[19] = static_cast<float>(page->session().scene().view().floor_height);
  return view.data();
}

// Points of the screen are those of OrbitCamera.
EMSCRIPTEN_KEEPALIVE int page_press(double x, double y, double aspect) {
  return page->press(page->camera().ray_through(x, y, aspect)) ? 1 : 0;
}
EMSCRIPTEN_KEEPALIVE void page_follow(double x, double y, double aspect) {
  page->follow(page->camera().ray_through(x, y, aspect));
}
EMSCRIPTEN_KEEPALIVE void page_release() {
  page->release();
}
EMSCRIPTEN_KEEPALIVE void page_orbit(double to_the_left, double upwards) {
  page->camera().orbit(to_the_left, upwards);
}
EMSCRIPTEN_KEEPALIVE void page_zoom(double factor) {
  page->camera().zoom(factor);
}

}  // extern "C"

}  // namespace softcd::demo

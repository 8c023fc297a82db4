#include "viewer/session.hpp"

#include <chrono>
#include <utility>

#include "snapshot_reader.hpp"
#include "world_kind.hpp"

namespace softcd::demo {

void History::add(float value) {
  if (values_.size() == kLength) values_.erase(values_.begin());
  values_.push_back(value);
}

Session::Session(std::string scene_name, const SceneOptions& options)
    : scene_name_(std::move(scene_name)), options_(options) {
  adopt(make_scene(scene_name_, options_));
}

void Session::adopt(std::unique_ptr<Scene> scene) {
  scene_ = std::move(scene);
  bodies_ = scene_->simulation().bodies();
}

void Session::step() {
  const auto start = std::chrono::steady_clock::now();
  scene_->step();
  const std::chrono::duration<float, std::milli> duration = std::chrono::steady_clock::now() - start;
  step_ms_.add(duration.count());
  if (const bullet::WorldDetection* detection = scene_->simulation().detection()) {
    detection_ms_.add(static_cast<float>(detection->contacts().statistics().ms.total));
  }
}

void Session::restart() {
  adopt(make_scene(scene_name_, options_));
}

void Session::go_on_with(const SceneOptions& options) {
  std::unique_ptr<Scene> scene = make_scene(scene_name_, options);
  scene->go_on_from(*scene_);
  adopt(std::move(scene));
  options_ = options;
}

std::unique_ptr<DetectionGrid> Session::make_grid() const {
  const bullet::WorldDetection* detection = scene_->simulation().detection();
  if (detection == nullptr) return nullptr;
  const bullet::WorldKind& kind = options_.world == World::classic ? bullet::kClassicWorld : bullet::kDeformableWorld;
  std::vector<bullet::BodyMesh> meshes;
  std::vector<GridBody> grid_bodies;
  meshes.reserve(bodies_.size());  // the bodies refer to them
  for (const btSoftBody* body : bodies_) {
    meshes.push_back(bullet::read_mesh(*body));
    grid_bodies.push_back(
        {{meshes.back().triangles, meshes.back().node_count, bullet::read_settings(kind, *body, detection->settings())},
         bullet::positions_of(*body, &btSoftBody::Node::m_q),
         bullet::positions_of(*body, &btSoftBody::Node::m_x)});
  }
  QueryOptions options = kind.contact_options(detection->settings());
  options.step_end = StepEnd::t1;  // where the nodes are drawn
  return std::make_unique<DetectionGrid>(grid_bodies, options);
}

}  // namespace softcd::demo

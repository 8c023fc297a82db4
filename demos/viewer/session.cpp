#include "viewer/session.hpp"

#include <chrono>
#include <utility>

#include "bodies/body_mesh.hpp"
#include "contacts/contacts_of_kind.hpp"

namespace softcd::demo {

namespace {

void set_read_out(bullet::WorldDetection& detection, bullet::ReadOut read_out) {
  if (detection.settings().read_out == read_out) return;
  bullet::Settings settings = detection.settings();
  settings.read_out = read_out;
  detection.set_settings(settings);
}

}  // namespace

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
  body_contacts_.clear();
}

void Session::step() {
  bullet::WorldDetection* const detection = scene_->simulation().detection();
  if (detection != nullptr)
    set_read_out(*detection, reads_contacts_ ? bullet::ReadOut::contacts : bullet::ReadOut::off);
  const auto start = std::chrono::steady_clock::now();
  scene_->step();
  const std::chrono::duration<float, std::milli> duration = std::chrono::steady_clock::now() - start;
  step_ms_.add(duration.count());
  body_contacts_.clear();
  if (detection == nullptr) return;
  detection_ms_.add(static_cast<float>(detection->contact_report().statistics().ms.total));
  if (reads_contacts_) body_contacts_ = detection->body_contacts();
}

void Session::restart() {
  adopt(make_scene(scene_name_, options_));
}

void Session::open(const std::string& scene_name) {
  SceneOptions options = options_;
  options.size = 0;
  adopt(make_scene(scene_name, options));
  scene_name_ = scene_name;
  options_ = options;
}

void Session::throw_ball(const btVector3& center, btScalar radius, const btVector3& velocity) {
  scene_->throw_ball(center, radius, velocity);
  bodies_ = scene_->simulation().bodies();
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
  const bullet::ContactsOfKind& kind =
      options_.world == World::classic ? bullet::kClassicContacts : bullet::kDeformableContacts;
  std::vector<bullet::BodyMesh> meshes;
  std::vector<GridBody> grid_bodies;
  meshes.reserve(bodies_.size());  // the bodies refer to them
  for (const btSoftBody* body : bodies_) {
    meshes.push_back(bullet::read_mesh(*body));
    grid_bodies.push_back({{meshes.back().triangles, meshes.back().node_count,
                            bullet::read_settings(kind.ends, *body, detection->settings())},
                           bullet::positions_of(*body, &btSoftBody::Node::m_q),
                           bullet::positions_of(*body, &btSoftBody::Node::m_x)});
  }
  QueryOptions options = kind.options(detection->settings());
  options.step_end = StepEnd::t1;  // where the nodes are drawn
  return std::make_unique<DetectionGrid>(grid_bodies, options);
}

}  // namespace softcd::demo

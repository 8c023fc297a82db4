#include "softcd/scene.hpp"

#include "scene_core.hpp"
#include "softcd/fields/options.hpp"

// Defined by every version: the linker refuses a program that holds two static libraries of softcd, by this name.
extern "C" void one_program_cannot_link_two_versions_of_softcd() {}

bool softcd::operator==(const SceneOptions& a, const SceneOptions& b) {
  return has_equal_fields(a, b);
}

namespace softcd {

Scene::Scene(const SceneOptions& options, LogCallback log)
    : core_(guarded(
          [] { return detail::kNoMemoryAtAll; },
          [&] { return std::make_shared<detail::SceneCore>(options, std::move(log), machine_factories(options)); })) {}
Scene::Scene(Scene&&) noexcept = default;
Scene::~Scene() {
  if (core_ != nullptr) core_->close();
}
Scene& Scene::operator=(Scene&& other) noexcept {
  Scene taken(std::move(other));
  std::swap(core_, taken.core_);
  return *this;
}

detail::SceneCore& Scene::core() const {
  if (core_ == nullptr) {
    throw Error("this Scene was moved from; assign one to it, or use the one that it was moved to.");
  }
  return *core_;
}

std::shared_ptr<detail::SceneCore> Scene::shared_core() const {
  core();
  return core_;
}

BodyId Scene::add_body(const BodyDesc& desc) {
  return core().add_body(desc);
}
void Scene::update_body(BodyId body, const BodyDesc& desc) {
  core().update_body(body, desc);
}
void Scene::update_body(BodyId body, const BodyDesc& desc, Span<const std::uint32_t> changed) {
  core().update_body(body, desc, changed);
}
void Scene::set_settings(BodyId body, const BodySettings& settings) {
  core().set_settings(body, settings);
}
void Scene::remove_body(BodyId body) {
  core().remove_body(body);
}
bool Scene::has_body(BodyId body) const {
  return core().has_body(body);
}
void Scene::set_positions(BodyId body, Positions x) {
  core().set_positions(body, x, x, /*has_step_end=*/false);
}
void Scene::set_positions(BodyId body, Positions x_t0, Positions x_t1) {
  core().set_positions(body, x_t0, x_t1, /*has_step_end=*/true);
}
void Scene::set_ignored_pairs(Span<const BodyPair> pairs) {
  core().set_ignored_pairs(pairs);
}
void Scene::set_vertex_filters(BodyId body, Span<const VertexFilter> filters) {
  core().set_vertex_filters(body, filters);
}
void Scene::set_rest_positions(BodyId body, Positions x) {
  core().set_rest_positions(body, x);
}
void Scene::set_options(const SceneOptions& options) {
  core().set_options(options);
}
const SceneOptions& Scene::options() const {
  return core().options();
}
void Scene::set_log(LogCallback log) {
  core().set_log(std::move(log));
}
Backend Scene::backend() const {
  return core().backend();
}

}  // namespace softcd

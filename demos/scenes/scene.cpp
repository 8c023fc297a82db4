#include "scenes/scene.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes/cloth_on_ball.hpp"
#include "scenes/folding_cloth.hpp"
#include "scenes/penetration.hpp"
#include "scenes/two_cloths.hpp"

namespace softcd::demo {
namespace {

template <class AnyScene>
std::unique_ptr<Scene> make(const SceneOptions& options) {
  return std::make_unique<AnyScene>(options);
}

}  // namespace

Scene::Scene(const SceneOptions& options)
    : simulation_(options.world, options.collision == Collision::softcd ? options.plug_in : PlugIn::none,
                  options.settings),
      collision_(options.collision) {}

void Scene::step() {
  animate();
  const long steps = std::lround(kTimeStep / simulation_.time_step());
  for (long i = 0; i < steps; ++i) simulation_.step();
  ++step_count_;
}

btSoftBody& Scene::add(std::unique_ptr<btSoftBody> body) {
  btSoftBody& added = simulation_.add(std::move(body));
  if (collision_ == Collision::off) simulation_.stop_soft_contacts();
  return added;
}

std::size_t Scene::count_penetrating_vertices() const {
  std::vector<const btSoftBody*> bodies;
  for (const Surface& surface : surfaces()) bodies.push_back(surface.body);
  std::vector<std::vector<bool>> marked = find_piercing_vertices(bodies);
  std::size_t count = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    mark_passed_through(*bodies[b], marked[b]);
    count += static_cast<std::size_t>(std::count(marked[b].begin(), marked[b].end(), true));
  }
  return count;
}

std::size_t Scene::count_contacts() const {
  return simulation_.count_soft_contacts();
}

const std::vector<SceneInfo>& scenes() {
  static const std::vector<SceneInfo> list = {
      {"cloth-on-ball", "A cloth drapes over a ball, which then turns and twists it into folds", "nodes a side", 8, 80,
       true, make<ClothOnBall>},
      {"two-cloths", "A cloth falls onto another one that is held along its border", "nodes a side", 8, 60, true,
       make<TwoCloths>},
      {"folding-cloth", "A cloth folded into four layers falls onto itself", "nodes a side", 8, 40, true,
       make<FoldingCloth>},
  };
  return list;
}

const SceneInfo* find_scene(const std::string& name) {
  const auto& list = scenes();
  const auto info = std::find_if(list.begin(), list.end(), [&](const SceneInfo& scene) { return scene.name == name; });
  return info == list.end() ? nullptr : &*info;
}

std::unique_ptr<Scene> make_scene(const std::string& name, SceneOptions options) {
  const SceneInfo* info = find_scene(name);
  if (info == nullptr) throw std::invalid_argument("there is no scene '" + name + "'");
  if (options.size == 0) options.size = info->default_size;
  if (options.size < info->smallest_size) {
    throw std::invalid_argument(name + " needs at least " + std::to_string(info->smallest_size) + " " +
                                info->size_unit);
  }
  if (options.world == World::deformable && !info->in_deformable_world) {
    throw std::invalid_argument(name +
                                " has bodies that keep their shape by what only Bullet's classic soft world "
                                "does; run it with --world soft");
  }
  return info->make(options);
}

}  // namespace softcd::demo

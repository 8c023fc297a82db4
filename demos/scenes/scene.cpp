#include "scenes/scene.hpp"

#include <algorithm>
#include <stdexcept>

#include "scenes/cloth_on_ball.hpp"
#include "scenes/folding_cloth.hpp"
#include "scenes/penetration.hpp"
#include "scenes/two_cloths.hpp"

namespace softcd::demo {

Scene::Scene(const SceneOptions& options)
    : simulation_(options.collision == Collision::softcd ? options.plug_in : PlugIn::none, options.settings),
      collision_(options.collision) {}

void Scene::step() {
  animate();
  simulation_.step(kTimeStep);
  ++step_count_;
}

btSoftBody& Scene::add(std::unique_ptr<btSoftBody> body) {
  if (collision_ == Collision::off) body->m_cfg.collisions &= ~btSoftBody::fCollision::VF_SS;
  return simulation_.add(std::move(body));
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
  std::size_t count = 0;
  for (const Surface& surface : surfaces()) count += static_cast<std::size_t>(surface.body->m_scontacts.size());
  return count;
}

const std::vector<SceneInfo>& scenes() {
  static const std::vector<SceneInfo> list = {
      {"cloth-on-ball", "A cloth drapes over a ball, which then turns and twists it into folds", 80},
      {"two-cloths", "A cloth falls onto another one that is held along its border", 60},
      {"folding-cloth", "A cloth folded into four layers falls onto itself", 40},
  };
  return list;
}

std::unique_ptr<Scene> make_scene(const std::string& name, SceneOptions options) {
  const auto& list = scenes();
  const auto info = std::find_if(list.begin(), list.end(), [&](const SceneInfo& scene) { return scene.name == name; });
  if (info == list.end()) throw std::invalid_argument("there is no scene '" + name + "'");
  if (options.nodes_per_side == 0) options.nodes_per_side = info->default_nodes_per_side;
  if (options.nodes_per_side < 8) throw std::invalid_argument("a cloth needs at least 8 nodes a side");
  if (name == "two-cloths") return std::make_unique<TwoCloths>(options);
  if (name == "folding-cloth") return std::make_unique<FoldingCloth>(options);
  return std::make_unique<ClothOnBall>(options);
}

}  // namespace softcd::demo

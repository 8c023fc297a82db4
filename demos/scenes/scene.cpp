#include "scenes/scene.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes/bowline.hpp"
#include "scenes/cloth_on_ball.hpp"
#include "scenes/flamenco.hpp"
#include "scenes/folding_cloth.hpp"
#include "scenes/funnel.hpp"
#include "scenes/mixed_sizes.hpp"
#include "scenes/n_body.hpp"
#include "scenes/penetration.hpp"
#include "scenes/reef_knot.hpp"
#include "scenes/refining.hpp"
#include "scenes/soft_ball.hpp"
#include "scenes/stack.hpp"
#include "scenes/tearing.hpp"
#include "scenes/tube.hpp"
#include "scenes/two_cloths.hpp"
#include "scenes/untangling.hpp"

namespace softcd::demo {
namespace {

constexpr int kBallSubdivisions = 2;
constexpr btScalar kBallMass = btScalar(0.5);

template <class AnyScene>
std::unique_ptr<Scene> make(const SceneOptions& options) {
  return std::make_unique<AnyScene>(options);
}

}  // namespace

Scene::Scene(const SceneOptions& options)
    : simulation_(options.world, options.collision == Collision::softcd ? options.plug_in : PlugIn::none,
                  options.settings),
      collision_(options.collision),
      iterations_(options.iterations),
      time_step_(options.time_step > 0 ? options.time_step : kTimeStep),
      bullets_steps_(options.time_step > 0 ? 1 : std::lround(kTimeStep / simulation_.time_step())) {
  if (options.size <= 0) throw std::invalid_argument("a scene needs a size; make_scene() knows the default");
}

void Scene::step() {
  animate();
  for (long i = 0; i < bullets_steps_; ++i) simulation_.step(time_step_ / btScalar(bullets_steps_));
  ++step_count_;
}

void Scene::go_on_from(const Scene& other) {
  for (std::size_t i = thrown_balls_.size(); i < other.thrown_balls_.size(); ++i) {
    throw_ball(btVector3(0, 0, 0), other.thrown_balls_[i].radius, btVector3(0, 0, 0));
  }
  // In the first step Bullet measures the links' rest lengths.
  if (step_count_ == 0) step();
  step_count_ = other.step_count_;
  repeat_changes(other);
  const std::vector<btSoftBody*>& bodies = simulation_.bodies();
  const std::vector<btSoftBody*>& others = other.simulation_.bodies();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const auto& from = others[b]->m_nodes;
    for (int i = 0; i < from.size(); ++i) {
      btSoftBody::Node& node = bodies[b]->m_nodes[i];
      node.m_x = from[i].m_x;
      node.m_q = from[i].m_q;
      node.m_v = from[i].m_v;
      node.m_vn = from[i].m_vn;
    }
  }
}

void Scene::throw_ball(const btVector3& center, btScalar radius, const btVector3& velocity) {
  auto ball = make_soft_ball(simulation_, {center, radius, kBallSubdivisions, kBallMass, radius / 10});
  ball->setVelocity(velocity);
  thrown_balls_.push_back({&add(std::move(ball)), radius});
}

std::vector<Surface> Scene::all_surfaces() const {
  constexpr Color kOutside = {0.55F, 0.12F, 0.10F};
  std::vector<Surface> all = surfaces();
  for (const ThrownBall& ball : thrown_balls_) all.push_back({ball.body, kOutside, kOutside});
  return all;
}

btSoftBody& Scene::add(std::unique_ptr<btSoftBody> body) {
  if (iterations_ > 0) body->m_cfg.piterations = iterations_;
  btSoftBody& added = simulation_.add(std::move(body));
  if (collision_ == Collision::off) simulation_.stop_soft_contacts();
  return added;
}

void Scene::send(btSoftBody& body, const std::vector<btVector3>& goals) const {
  int i = 0;
  for (const btVector3& goal : goals) {
    btSoftBody::Node& node = body.m_nodes[i++];
    node.m_v = (goal - node.m_x) / time_step_;
  }
}

std::vector<btVector3> Scene::positions_of(const btSoftBody& body) {
  std::vector<btVector3> positions;
  positions.reserve(static_cast<std::size_t>(body.m_nodes.size()));
  for (int i = 0; i < body.m_nodes.size(); ++i) positions.push_back(body.m_nodes[i].m_x);
  return positions;
}

Penetration Scene::count_penetration() const {
  std::vector<const btSoftBody*> bodies;
  for (const Surface& surface : surfaces()) bodies.push_back(surface.body);
  Intersections intersections = find_intersections(bodies);
  Penetration penetration{0, intersections.edge_count};
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    std::vector<bool>& marked = intersections.vertices[b];
    mark_passed_through(*bodies[b], marked);
    penetration.vertices += static_cast<std::size_t>(std::count(marked.begin(), marked.end(), true));
  }
  return penetration;
}

std::size_t Scene::count_triangles() const {
  std::size_t count = 0;
  for (const Surface& surface : surfaces()) count += static_cast<std::size_t>(surface.body->m_faces.size());
  return count;
}

std::size_t Scene::count_contacts() const {
  return simulation_.count_soft_contacts();
}

const std::vector<SceneInfo>& scenes() {
  static const std::vector<SceneInfo> list = {
      {"cloth-on-ball", "A cloth drapes over a ball, which then turns and twists it into folds", "nodes a side", 8, 80,
       190, true, make<ClothOnBall>},
      {"funnel", "A cloth falls into a funnel and is pulled through its spout", "nodes a side", 12, 40, 84, true,
       make<Funnel>},
      {"flamenco", "A dancer turns and sways in a skirt of three layers", "cells along the skirt", 8, 15, 50, true,
       make<Flamenco>},
      {"n-body", "Soft balls fall onto cones, a floor and each other", "balls", 1, 40, 455, true, make<NBody>},
      {"reef-knot", "Two ribbons in a loose reef knot are pulled tight", "nodes along each ribbon", 80, 150, 430, true,
       make<ReefKnot>},
      {"bowline", "A ribbon with a loose bowline round a post is pulled tight", "nodes along the ribbon", 120, 240, 660,
       true, make<Bowline>},
      {"stack", "Cloths fall onto each other, the lowest one is held", "nodes a side", 8, 16, 0, true, make<Stack>},
      {"tube", "A soft tube collapses under its own weight and lies in folds on itself", "nodes around it", 16, 36, 0,
       true, make<Tube>},
      {"mixed-sizes-cloth", "A cloth falls onto another one; triangles from 1 to 10,000 in area", "segments", 16, 48, 0,
       true, make<MixedSizesCloth>},
      {"mixed-sizes-balls", "Small soft balls fall between boulders; triangles from 1 to 10,000 in area", "small balls",
       1, 10, 0, false, make<MixedSizesBalls>},
      {"two-cloths", "A cloth falls onto another one that is held along its border", "nodes a side", 8, 60, 0, true,
       make<TwoCloths>},
      {"folding-cloth", "A cloth folded into four layers falls onto itself", "nodes a side", 8, 40, 0, true,
       make<FoldingCloth>},
      {"tearing", "A ball is driven through a cloth, which tears", "nodes a side", 8, 40, 0, true, make<Tearing>,
       /*in_bullets_detection=*/false},
      {"refining", "A coarse sheet falls over a ball and is refined where it folds", "nodes a side", 8, 20, 0, true,
       make<Refining>},
      {"untangling", "Cloths and balls that start through each other come apart", "nodes along a cloth", 8, 16, 0, true,
       make<Untangling>, /*in_bullets_detection=*/true, /*starts_tangled=*/true},
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
    throw std::invalid_argument(name + " runs in Bullet's classic soft world only; docs/use/scenes.md says why");
  }
  if (options.collision == Collision::bullet && !info->in_bullets_detection) {
    throw std::invalid_argument(name + " cannot have Bullet's own detection; docs/use/scenes.md says why");
  }
  return info->make(options);
}

}  // namespace softcd::demo

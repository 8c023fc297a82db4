#include "trade_simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>
#include <optional>
#include <utility>

#include "soft_body_steps.hpp"

#include "command_line/choices.hpp"
#include "command_line/stage_times.hpp"
#include "scenes/cloth.hpp"
#include "scenes/penetration.hpp"
#include "scenes/soft_world.hpp"
#include "scenes/two_cloths.hpp"

namespace softcd::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

/// A detector and its settings. The defaults are the base point from which each knob is varied.
struct Setting {
  enum class Detector { bullet, dcd, ccd };

  Detector detector = Detector::ccd;
  int steps_per_second = 120;
  bullet::EdgeContacts edge_contacts = bullet::EdgeContacts::off;
  Accuracy accuracy = Accuracy::precise;
  double margin_in_cells = 0.25;
  float cell_size_factor = 0;
  int iterations = 4;
  bullet::Contacts contacts = bullet::Contacts::all;
  std::uint32_t contacts_per_node = 0;
  std::string knob, value;
};

constexpr std::array<demo::Choice<Setting::Detector>, 3> kDetectors = {
    {{"bullet", Setting::Detector::bullet}, {"dcd", Setting::Detector::dcd}, {"ccd", Setting::Detector::ccd}}};
constexpr std::array kStepsPerSecond = {30, 60, 120, 240, 480, 960};
constexpr int kSamplesPerSecond = 30;

/// The deformable world integrates springs explicitly, and longer steps than these are unstable there. Its solver has
/// no position iterations.
constexpr int kFewestDeformableSteps = 120;

std::vector<Setting> settings(demo::World world) {
  using bullet::EdgeContacts;
  std::vector<Setting> all;
  for (const auto& [detector, edges] :
       {std::pair(Setting::Detector::bullet, EdgeContacts::off), std::pair(Setting::Detector::dcd, EdgeContacts::off),
        std::pair(Setting::Detector::ccd, EdgeContacts::off),
        std::pair(Setting::Detector::ccd, EdgeContacts::respond)}) {
    for (const int steps : kStepsPerSecond) {
      if (world == demo::World::deformable && steps < kFewestDeformableSteps) continue;
      Setting setting;
      setting.detector = detector;
      setting.edge_contacts = edges;
      setting.steps_per_second = steps;
      setting.knob = "time step";
      setting.value = fmt::format("1/{}", steps);
      all.push_back(setting);
    }
  }
  const auto turn = [&](const std::string& knob, const std::string& value, auto member, auto to) {
    Setting setting;
    setting.*member = to;
    setting.knob = knob;
    setting.value = value;
    all.push_back(setting);
  };
  for (const auto& [name, accuracy] : demo::kChoices<Accuracy>) {
    if (accuracy != Accuracy::precise && accuracy != Accuracy::automatic)
      turn("accuracy", name, &Setting::accuracy, accuracy);
  }
  for (const double margin : {0.0625, 0.125, 0.5}) {
    turn("margin", fmt::format("{} cells", margin), &Setting::margin_in_cells, margin);
  }
  for (const float factor : {1.2F, 2.4F}) {
    turn("cell size factor", fmt::format("{:.1f}", factor), &Setting::cell_size_factor, factor);
  }
  if (world == demo::World::classic) {
    turn("contacts", "closest feature", &Setting::contacts, bullet::Contacts::closest_feature);
  }
  for (const std::uint32_t most : {1U, 2U}) {
    turn("contacts", fmt::format("{} a node", most), &Setting::contacts_per_node, most);
  }
  for (const int iterations : {1, 2, 8, 16}) {
    if (world == demo::World::deformable) break;
    turn("iterations", fmt::to_string(iterations), &Setting::iterations, iterations);
  }
  return all;
}

demo::SoftWorld make_simulation(const Setting& setting, const SimulationOptions& options) {
  bullet::Settings ours;
  ours.backend = options.backend;
  ours.detection = setting.detector == Setting::Detector::ccd ? Detection::ccd : Detection::dcd;
  ours.accuracy = setting.accuracy;
  ours.cell_size_factor = setting.cell_size_factor;
  ours.edge_contacts = setting.edge_contacts;
  ours.contacts = setting.contacts;
  ours.contacts_per_node = setting.contacts_per_node;
  const bool is_ours = setting.detector != Setting::Detector::bullet;
  return demo::SoftWorld(options.world, is_ours ? demo::PlugIn::one_line_world : demo::PlugIn::none, ours);
}

// Each function fills an empty world and returns the size of the cells of its cloths.

btScalar fill_throw(demo::SoftWorld& simulation, int nodes_per_side) {
  constexpr btScalar kSide = 2;
  constexpr btScalar kSpeed = 50;
  const int last = nodes_per_side - 1;
  demo::ClothShape held = demo::horizontal_cloth(nodes_per_side, kSide, 0);
  held.is_fixed = [last](int column, int row) { return column == 0 || row == 0 || column == last || row == last; };
  const int thrown_nodes = nodes_per_side / 2 + 1;
  const btScalar cell = kSide / btScalar(last);
  simulation.add(demo::make_cloth(simulation.world_info(), held, 20));
  btSoftBody& thrown = simulation.add(
      demo::make_cloth(simulation.world_info(),
                       demo::horizontal_cloth(thrown_nodes, cell * btScalar(thrown_nodes - 1), btScalar(0.6)), 1));
  thrown.rotate(btQuaternion(btVector3(0, 1, 0), btScalar(0.35)));
  thrown.setVelocity(btVector3(0, -kSpeed, 0));
  return cell;
}

btScalar fill_two_cloths(demo::SoftWorld& simulation, int nodes_per_side) {
  constexpr btScalar kSpeed = 10;
  demo::LowerAndUpperCloth cloths = demo::make_two_cloths(simulation.world_info(), nodes_per_side);
  btSoftBody& lower = simulation.add(std::move(cloths.lower));
  const btScalar cell = (lower.m_nodes[1].m_x - lower.m_nodes[0].m_x).length();
  btSoftBody& upper = simulation.add(std::move(cloths.upper));
  upper.setVelocity(btVector3(0, -kSpeed, 0));
  return cell;
}

btScalar fill_cloth_on_ball(demo::SoftWorld& simulation, int nodes_per_side) {
  constexpr btScalar kSide = 3;
  constexpr btScalar kRadius = 1;
  constexpr btScalar kSpeed = 20;
  simulation.add(demo::make_ball(simulation.world_info(), btVector3(0, 0, 0), kRadius, 3));
  btSoftBody& cloth = simulation.add(
      demo::make_cloth(simulation.world_info(), demo::horizontal_cloth(nodes_per_side, kSide, btScalar(1.2)), 1));
  cloth.setVelocity(btVector3(0, -kSpeed, 0));
  return kSide / btScalar(nodes_per_side - 1);
}

/// Fills a world with three layers of one cloth, joined by half circles; the lowest layer is held.
btScalar fill_folded(demo::SoftWorld& simulation, int nodes_per_side) {
  constexpr btScalar kSide = 2;
  constexpr btScalar kGap = btScalar(0.3);
  const int flat = nodes_per_side - 1;
  const btScalar cell = kSide / btScalar(flat);
  const int bend = std::max(2, static_cast<int>(std::lround(SIMD_HALF_PI * kGap / cell)));
  demo::ClothShape shape;
  shape.columns = 3 * flat + 2 * bend + 1;
  shape.rows = nodes_per_side;
  shape.position = [=](int column, int row) {
    const int layer = column / (flat + bend);
    const int along = column % (flat + bend);
    const btScalar angle = SIMD_PI * btScalar(std::max(0, along - flat)) / btScalar(bend);
    const btScalar x = cell * btScalar(std::min(along, flat)) + kGap / 2 * btSin(angle);
    return btVector3(layer % 2 == 1 ? kSide - x : x, kGap * (btScalar(layer) + (1 - btCos(angle)) / 2),
                     cell * btScalar(row));
  };
  shape.is_fixed = [flat](int column, int) { return column <= flat; };
  simulation.add(demo::make_cloth(simulation.world_info(), shape, 2));
  return cell;
}

struct SceneChoice {
  const char* name;
  btScalar (*fill)(demo::SoftWorld&, int);
  double most_seconds;
};
constexpr SceneChoice kScenesOfBullet[] = {{"throw", fill_throw, 0.25},
                                           {"two-cloths", fill_two_cloths, 10},
                                           {"cloth-on-ball", fill_cloth_on_ball, 10},
                                           {"folded", fill_folded, 0.5}};

/// Counts vertices that pass through a triangle on their straight path through a step, in exact arithmetic.
class CrossingCounter {
 public:
  explicit CrossingCounter(const std::vector<btSoftBody*>& bodies) : finder_(bodies) {
    for (const btSoftBody* body : bodies) is_odd_.emplace_back(static_cast<std::size_t>(body->m_nodes.size()), false);
  }

  void count_step() {
    for (const test::FeaturePair& pair : finder_.find()) {
      ++crossings_;
      is_odd_[pair.body_a][pair.feature_a].flip();
    }
  }

  std::size_t crossings() const { return crossings_; }
  std::size_t tunnelled() const {
    std::size_t count = 0;
    for (const auto& body : is_odd_) count += static_cast<std::size_t>(std::count(body.begin(), body.end(), true));
    return count;
  }

 private:
  test::CrossingFinder finder_;
  std::vector<std::vector<bool>> is_odd_;
  std::size_t crossings_ = 0;
};

double energy_of(const std::vector<btSoftBody*>& bodies, const btVector3& gravity) {
  double energy = 0;
  for (const btSoftBody* body : bodies) {
    for (int n = 0; n < body->m_nodes.size(); ++n) {
      const btSoftBody::Node& node = body->m_nodes[n];
      if (node.m_im == 0) continue;
      energy += double(node.m_v.length2() / 2 - gravity.dot(node.m_x)) / double(node.m_im);
    }
  }
  return energy;
}

std::size_t count_penetrating(const std::vector<btSoftBody*>& bodies) {
  std::size_t count = 0;
  for (const auto& body : demo::find_intersections({bodies.begin(), bodies.end()}).vertices) {
    count += static_cast<std::size_t>(std::count(body.begin(), body.end(), true));
  }
  return count;
}

/// Observes the bodies of a run. Not part of the measured time.
class Observer {
 public:
  Observer(demo::SoftWorld& simulation, SimulationResult& result)
      : simulation_(simulation),
        bodies_(simulation.bodies()),
        gravity_(simulation.world_info().m_gravity),
        crossings_(simulation.bodies()),
        result_(result) {
    result_.energy_start = result_.energy_most = energy_of(bodies_, gravity_);
    for (const btSoftBody* body : bodies_) result_.vertices += static_cast<std::size_t>(body->m_nodes.size());
  }

  void see_step(bool is_sample) {
    contacts_ += static_cast<double>(simulation_.count_soft_contacts());
    result_.contacts = contacts_ / ++steps_;
    crossings_.count_step();
    result_.crossings = crossings_.crossings();
    result_.tunnelled = crossings_.tunnelled();
    result_.energy_end = energy_of(bodies_, gravity_);
    result_.energy_most = std::max(result_.energy_most, result_.energy_end);
    if (!is_sample) return;
    result_.penetrating = count_penetrating(bodies_);
    result_.most_penetrating = std::max(result_.most_penetrating, result_.penetrating);
  }

 private:
  const demo::SoftWorld& simulation_;
  const std::vector<btSoftBody*>& bodies_;
  btVector3 gravity_;
  CrossingCounter crossings_;
  SimulationResult& result_;
  double contacts_ = 0;
  int steps_ = 0;
};

SimulationResult describe(const SceneChoice& scene, const Setting& setting, const SimulationOptions& options) {
  SimulationResult result;
  result.scene = scene.name;
  result.world = options.world;
  result.knob = setting.knob;
  result.value = setting.value;
  result.detection = name_of(kDetectors, setting.detector);
  result.features = setting.edge_contacts == bullet::EdgeContacts::respond ? "vt,ee" : "vt";
  result.accuracy = demo::name_of(setting.accuracy);
  result.backend = options.backend;
  result.steps_per_second = setting.steps_per_second;
  result.margin_in_cells = setting.margin_in_cells;
  result.cell_size_factor = static_cast<double>(setting.cell_size_factor);
  result.iterations = setting.iterations;
  result.seconds = std::min(options.seconds, scene.most_seconds);
  return result;
}

/// The time of a simulated second, in milliseconds.
struct Cost {
  double elapsed = 0;
  double processor = 0;
};

double processor_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Runs a setting and returns the cost of all steps but the first, which allocates trees and buffers. Every run of a
/// setting makes the same steps; the first run is observed.
Cost run(const SceneChoice& scene, const Setting& setting, const SimulationOptions& options, bool is_observed,
         SimulationResult& result) {
  demo::SoftWorld simulation = make_simulation(setting, options);
  const btScalar cell = scene.fill(simulation, options.nodes_per_side);
  for (btSoftBody* body : simulation.bodies()) {
    body->getCollisionShape()->setMargin(btScalar(setting.margin_in_cells) * cell);
    body->m_cfg.piterations = setting.iterations;
    body->m_cfg.kDF = btScalar(0.5);
    body->setSelfCollision(true);
  }
  std::optional<Observer> observer;
  if (is_observed) observer.emplace(simulation, result);
  const int steps = static_cast<int>(std::lround(result.seconds * setting.steps_per_second));
  const int steps_per_sample = std::max(1, setting.steps_per_second / kSamplesPerSecond);
  Cost cost;
  for (int step = 1; step <= steps; ++step) {
    const Clock::time_point start = Clock::now();
    const double processor_start = processor_ms();
    simulation.step(btScalar(1) / btScalar(setting.steps_per_second));
    if (step > 1) {
      cost.elapsed += std::chrono::duration<double, std::milli>(Clock::now() - start).count();
      cost.processor += processor_ms() - processor_start;
    }
    if (observer) observer->see_step(step % steps_per_sample == 0 || step == steps);
  }
  const double steps_of_cost = std::max(1, steps - 1);
  return {cost.elapsed * setting.steps_per_second / steps_of_cost,
          cost.processor * setting.steps_per_second / steps_of_cost};
}

}  // namespace

void run_simulations(const SimulationOptions& options, const std::function<void(const SimulationResult&)>& report) {
  const std::vector<Setting> all = settings(options.world);
  for (const SceneChoice& scene : kScenesOfBullet) {
    std::vector<SimulationResult> results;
    results.reserve(all.size());
    for (const Setting& setting : all) results.push_back(describe(scene, setting, options));
    // One run of each setting in turn, so that other load on the machine affects all of them.
    std::vector<std::vector<double>> elapsed(all.size()), processor(all.size());
    for (int repetition = 0; repetition < options.repetitions; ++repetition) {
      for (std::size_t i = 0; i < all.size(); ++i) {
        const Cost cost = run(scene, all[i], options, repetition == 0, results[i]);
        elapsed[i].push_back(cost.elapsed);
        processor[i].push_back(cost.processor);
      }
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
      results[i].ms_per_second = demo::median(elapsed[i]);
      results[i].processor_ms_per_second = demo::median(processor[i]);
      report(results[i]);
    }
  }
}

}  // namespace softcd::benchmarks

#include "untangling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "report.hpp"
#include "scenes/intersecting_bodies.hpp"
#include "scenes/penetration.hpp"
#include "scenes/scene.hpp"
#include "scenes/step_profile.hpp"

// Lets bodies that intersect at the start come apart, and measures the time that the search for intersections takes in
// a world without any.

namespace softcd::benchmarks {
namespace {

constexpr double kSeconds = 2;
constexpr int kStepsBetweenCounts = 4;
constexpr std::array<double, 5> kTimes = {0, 0.1, 0.25, 0.5, 1};

struct Mode {
  const char* name;
  std::optional<bullet::Settings> settings;  ///< none: Bullet alone
};

std::vector<Mode> modes() {
  const auto of = [](bullet::Settings settings, bullet::Untangle untangle) {
    settings.backend = Backend::cpu;
    settings.self_collision = bullet::SelfCollision::all;
    settings.untangle = untangle;
    settings.untangle_speed = 1;
    return settings;
  };
  return {{"Bullet", std::nullopt},
          {"softcd", of({}, bullet::Untangle::off)},
          {"untangle, dcd", of({}, bullet::Untangle::all)},
          {"untangle, ccd", of(bullet::Settings::safe(), bullet::Untangle::all)}};
}

struct Outcome {
  std::array<std::size_t, kTimes.size()> edges{};
  std::size_t edges_at_end = 0;
  int steps_to_zero = -1;
  double fastest = 0, energy = 0;
  double drift = 0;      ///< greatest speed of the common centre of mass
  bool is_free = false;  ///< whether everything can move
};

/// Sums over nodes and rigid bodies.
struct Motion {
  btVector3 momentum{0, 0, 0};
  double mass = 0;
  double energy = 0;
  bool is_free = true;

  void add(const btVector3& velocity, btScalar inverse_mass) {
    is_free &= inverse_mass > 0;
    if (!(inverse_mass > 0)) return;
    momentum += velocity / inverse_mass;
    mass += 1 / double(inverse_mass);
    energy += double(velocity.length2()) / double(inverse_mass) / 2;
  }
};

void see(const std::vector<const btSoftBody*>& bodies, const std::vector<btRigidBody*>& rigid, Outcome& outcome) {
  Motion motion;
  for (const btSoftBody* body : bodies) {
    for (int i = 0; i < body->m_nodes.size(); ++i) {
      const btSoftBody::Node& node = body->m_nodes[i];
      motion.add(node.m_v, node.m_im);
      if (node.m_im > 0) outcome.fastest = std::max(outcome.fastest, double(node.m_v.length()));
    }
  }
  for (const btRigidBody* body : rigid) motion.add(body->getLinearVelocity(), body->getInvMass());
  outcome.energy = std::max(outcome.energy, motion.energy);
  outcome.drift = std::max(outcome.drift, double(motion.momentum.length()) / motion.mass);
  outcome.is_free = motion.is_free;
}

Outcome simulate(const demo::IntersectingBodies& kind, demo::World world, const Mode& mode, int size) {
  demo::SoftWorld simulation(world, mode.settings ? demo::PlugIn::one_line_world : demo::PlugIn::none,
                             mode.settings.value_or(bullet::Settings()));
  simulation.set_gravity(btVector3(0, 0, 0));
  std::vector<const btSoftBody*> bodies;
  for (auto& body : kind.make(simulation.world_info(), world, size)) bodies.push_back(&simulation.add(std::move(body)));
  demo::RigidMeshes meshes(
      kind, simulation.world_info(), [&](auto shape, const btVector3& center, btScalar mass) -> auto& {
        return simulation.add_rigid(std::move(shape), center, mass);
      });
  Outcome outcome;
  const int steps = static_cast<int>(kSeconds / double(simulation.time_step()));
  std::size_t next_time = 0;
  for (int step = 0; step <= steps; ++step) {
    const bool is_time = next_time < kTimes.size() && step * double(simulation.time_step()) >= kTimes[next_time] - 1e-6;
    if (is_time || step % kStepsBetweenCounts == 0 || step == steps) {
      std::vector<const btSoftBody*> all = bodies;
      meshes.append_copies(all);
      outcome.edges_at_end = demo::find_intersections(all).edge_count;
    }
    if (outcome.edges_at_end == 0 && outcome.steps_to_zero < 0) outcome.steps_to_zero = step;
    if (is_time) outcome.edges[next_time++] = outcome.edges_at_end;
    if (step == steps) break;
    simulation.step();
    see(bodies, meshes.bodies(), outcome);
  }
  return outcome;
}

struct CleanCost {
  demo::StepProfile step;  ///< mean
  int steps_with_intersections = 0;
};

/// Measures softcd's share of a step of a scene without intersections, over several searches.
CleanCost clean_cost(const char* name, Detection detection) {
  demo::SceneOptions options;
  options.settings.backend = Backend::cpu;
  options.settings.detection = detection;
  options.settings.edge_contacts =
      detection == Detection::ccd ? bullet::EdgeContacts::respond : bullet::EdgeContacts::off;
  options.settings.untangle = bullet::Untangle::all;
  const auto scene = demo::make_scene(name, options);
  constexpr int kWarmUp = 32;
  constexpr int kSteps = 160;  // searches are in one of 32
  demo::StepProfiler profiler;
  for (int step = 0; step < kWarmUp; ++step) scene->step();
  profiler.take();
  CleanCost cost;
  for (int step = 0; step < kSteps; ++step) {
    scene->step();
    cost.steps_with_intersections += scene->simulation().detection()->intersecting_bodies().empty() ? 0 : 1;
  }
  const demo::StepProfile sum = profiler.take();
  cost.step = {sum.contacts / kSteps, sum.crossings / kSteps, sum.untangling / kSteps};
  return cost;
}

void run(const UntanglingOptions& options) {
  Table table({"bodies", "world", "mode", "0 s", "0.1 s", "0.25 s", "0.5 s", "1 s", "2 s", "steps to 0", "m/s", "J",
               "drift m/s"},
              3);
  nlohmann::ordered_json json = describe_run("untangling", options.machine);
  const auto is_wanted = [&options](const char* name) {
    return options.bodies.empty() ||
           std::find(options.bodies.begin(), options.bodies.end(), name) != options.bodies.end();
  };
  for (const demo::IntersectingBodies& kind : demo::intersecting_bodies()) {
    if (!is_wanted(kind.name)) continue;
    for (const demo::World world : {demo::World::classic, demo::World::deformable}) {
      for (const Mode& mode : modes()) {
        const Outcome outcome = simulate(kind, world, mode, options.size);
        const std::string world_name = world == demo::World::classic ? "classic" : "deformable";
        std::vector<std::string> row = {kind.name, world_name, mode.name};
        for (const std::size_t edges : outcome.edges) row.push_back(fmt::to_string(edges));
        row.push_back(fmt::to_string(outcome.edges_at_end));
        row.push_back(outcome.steps_to_zero < 0 ? "never" : fmt::to_string(outcome.steps_to_zero));
        row.push_back(fmt::format("{:.1f}", outcome.fastest));
        row.push_back(fmt::format("{:.2g}", outcome.energy));
        row.push_back(outcome.is_free ? fmt::format("{:.1g}", outcome.drift) : "held");
        fmt::print(stderr, "{}\n", fmt::join(row, " "));
        table.add(row);
        json["untangling"].push_back({{"bodies", kind.name},
                                      {"world", world_name},
                                      {"mode", mode.name},
                                      {"edges", outcome.edges},
                                      {"edges_at_end", outcome.edges_at_end},
                                      {"steps_to_zero", outcome.steps_to_zero},
                                      {"fastest", outcome.fastest},
                                      {"energy", outcome.energy},
                                      {"drift", outcome.drift}});
      }
    }
  }
  Table costs({"scene", "detection", "softcd ms", "untangling ms", "share", "steps with intersections"}, 2);
  for (const char* name : {"two-cloths", "n-body", "folding-cloth"}) {
    if (!is_wanted("clean")) break;
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      const auto [cost, steps_with_intersections] = clean_cost(name, detection);
      costs.add({name, detection == Detection::dcd ? "dcd" : "ccd", fmt::format("{:.3f}", cost.total()),
                 fmt::format("{:.3f}", cost.untangling), fmt::format("{:.1f} %", 100 * cost.untangling / cost.total()),
                 fmt::to_string(steps_with_intersections)});
      json["clean"].push_back({{"scene", name},
                               {"detection", detection == Detection::dcd ? "dcd" : "ccd"},
                               {"softcd_ms", cost.total()},
                               {"untangling_ms", cost.untangling},
                               {"steps_with_intersections", steps_with_intersections}});
    }
  }
  const std::string report = fmt::format(
      "### Untangling\n\nEdges that intersect triangles, over time. Steps are of 1/120 s in the classic world and "
      "shorter in the deformable one; the count is made in every fourth. Greatest speed of a node, and greatest "
      "kinetic energy; all start at "
      "rest. Greatest speed of the common centre of mass, where nothing is held.\n\n{}\n### Clean worlds\n\nMean of "
      "160 steps.\n\n{}\n",
      table.text(), costs.text());
  fmt::print("{}", report);
  if (!options.markdown_file.empty()) write_file(options.markdown_file, report);
  if (!options.json_file.empty()) write_json(options.json_file, json);
}

}  // namespace

void add_untangling(CLI::App& app, UntanglingOptions& options) {
  CLI::App* command = app.add_subcommand(
      "untangling", "Lets soft bodies that start through each other come apart, with Bullet alone and with softcd");
  command
      ->add_option("--bodies", options.bodies,
                   "Kinds of bodies, and 'clean' for worlds without intersections. Default: all")
      ->option_text("NAME...")
      ->delimiter(',');
  command->add_option("--size", options.size, "Nodes along a cloth")->option_text("N [16]")->check(CLI::Range(6, 1000));
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the tables as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure")->option_text("FILE");
  command->callback([&options] { run(options); });
}

}  // namespace softcd::benchmarks

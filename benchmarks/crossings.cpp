#include "crossings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "command_line/world_choices.hpp"
#include "report.hpp"
#include "scenes/penetration.hpp"

// Checks the guarantee of continuous detection: counts edges through triangles after every step of the demo scenes, in
// exact arithmetic. Also measures what crossing prevention changed.

namespace softcd::benchmarks {
namespace {

using demo::name_of;

constexpr std::array<demo::Choice<SceneSize>, 3> kSizes = {
    {{"smallest", SceneSize::smallest}, {"default", SceneSize::usual}, {"paper", SceneSize::papers}}};

int size_of(const demo::SceneInfo& scene, SceneSize size) {
  if (size == SceneSize::smallest) return scene.smallest_size;
  return size == SceneSize::papers && scene.paper_size > 0 ? scene.paper_size : scene.default_size;
}

/// One simulation. Energies in J, of the nodes with mass.
struct Run {
  std::string scene;
  demo::World world = demo::World::classic;
  int steps_per_second = 0;
  long steps = 0;
  std::size_t triangles = 0;
  std::size_t edges_at_start = 0, most_edges = 0;  ///< that intersect triangles
  long steps_with_edges = 0;
  long answered_steps = 0;  ///< in which some features would have crossed
  std::uint64_t rounds = 0, most_rounds = 0, most_held_nodes = 0, unavoidable = 0, excepted = 0;
  double kinetic_energy = 0;   ///< largest
  double energy_gained = 0;    ///< largest gain by the responses of one step
  double energy_lost = 0;      ///< by the responses of all steps
  double momentum_gained = 0;  ///< largest gain by the responses of one step, as a share of sum(m |v|)
};

struct Motion {
  double energy = 0;
  double momentum = 0;  ///< sum of m |v|
};

Motion motion_of(const std::vector<btSoftBody*>& bodies) {
  Motion motion;
  for (const btSoftBody* body : bodies) {
    for (int n = 0; n < body->m_nodes.size(); ++n) {
      const btSoftBody::Node& node = body->m_nodes[n];
      if (node.m_im == 0) continue;
      motion.energy += double(node.m_v.length2()) / double(node.m_im) / 2;
      motion.momentum += double(node.m_v.length()) / double(node.m_im);
    }
  }
  return motion;
}

/// Counts crossing edges, except within bodies without self-collision.
std::size_t count_edges(const std::vector<btSoftBody*>& bodies) {
  const auto is_prevented = [](const btSoftBody& edges, const btSoftBody& triangles) {
    return &edges != &triangles || edges.m_useSelfCollision;
  };
  return demo::find_intersections({bodies.begin(), bodies.end()}, is_prevented).edge_count;
}

void see_step(const demo::SoftWorld& simulation, Run& run) {
  const std::size_t edges = count_edges(simulation.bodies());
  run.most_edges = std::max(run.most_edges, edges);
  run.steps_with_edges += edges > 0 ? 1 : 0;
  const Motion motion = motion_of(simulation.bodies());
  run.kinetic_energy = std::max(run.kinetic_energy, motion.energy);
  const bullet::CrossingAnswers answers = simulation.detection()->crossing_answers();
  run.excepted += answers.excepted;
  if (answers.rounds == 0) return;
  ++run.answered_steps;
  run.rounds += answers.rounds;
  run.most_rounds = std::max(run.most_rounds, answers.rounds);
  run.most_held_nodes = std::max(run.most_held_nodes, answers.held_nodes);
  run.unavoidable += answers.unavoidable;
  run.energy_gained = std::max(run.energy_gained, answers.energy);
  run.energy_lost -= std::min(0.0, answers.energy);
  const auto& [x, y, z] = answers.momentum;
  run.momentum_gained = std::max(run.momentum_gained, std::hypot(x, y, z) / std::max(motion.momentum, 1e-9));
}

Run simulate(const demo::SceneInfo& info, demo::World world, int steps_per_second, const CrossingsOptions& options) {
  demo::SceneOptions scene_options;
  scene_options.world = world;
  scene_options.size = size_of(info, options.size);
  scene_options.time_step = btScalar(1) / btScalar(steps_per_second);
  scene_options.settings.backend = options.backend;
  scene_options.settings.detection = Detection::ccd;
  scene_options.settings.edge_contacts = bullet::EdgeContacts::respond;
  scene_options.settings.contacts = options.contacts;
  const std::unique_ptr<demo::Scene> scene = demo::make_scene(info.name, scene_options);

  Run run;
  run.scene = info.name;
  run.world = world;
  run.steps_per_second = steps_per_second;
  run.triangles = scene->count_triangles();
  run.edges_at_start = count_edges(scene->simulation().bodies());
  const long steps = std::max(1L, std::lround(options.seconds * steps_per_second));
  const std::chrono::duration<double> time_limit(options.time_limit);
  const auto start = std::chrono::steady_clock::now();
  while (run.steps < steps && std::chrono::steady_clock::now() - start < time_limit) {
    scene->step();
    ++run.steps;
    see_step(scene->simulation(), run);
  }
  return run;
}

nlohmann::ordered_json to_json(const Run& run) {
  return {{"scene", run.scene},
          {"world", name_of(demo::kWorlds, run.world)},
          {"steps_per_second", run.steps_per_second},
          {"steps", run.steps},
          {"triangles", run.triangles},
          {"edges_at_start", run.edges_at_start},
          {"most_edges", run.most_edges},
          {"steps_with_edges", run.steps_with_edges},
          {"answered_steps", run.answered_steps},
          {"rounds", run.rounds},
          {"most_rounds", run.most_rounds},
          {"most_held_nodes", run.most_held_nodes},
          {"unavoidable", run.unavoidable},
          {"excepted", run.excepted},
          {"kinetic_energy", run.kinetic_energy},
          {"energy_gained", run.energy_gained},
          {"energy_lost", run.energy_lost},
          {"momentum_gained", run.momentum_gained}};
}

std::vector<std::string> to_row(const Run& run) {
  const double mean_rounds = static_cast<double>(run.rounds) / static_cast<double>(std::max(1L, run.answered_steps));
  return {run.scene,
          name_of(demo::kWorlds, run.world),
          fmt::format("1/{}", run.steps_per_second),
          fmt::to_string(run.triangles),
          fmt::to_string(run.edges_at_start),
          fmt::to_string(run.most_edges),
          fmt::format("{} of {}", run.steps_with_edges, run.steps),
          fmt::to_string(run.answered_steps),
          fmt::format("{:.1f}", mean_rounds),
          fmt::to_string(run.most_rounds),
          fmt::to_string(run.most_held_nodes),
          fmt::to_string(run.unavoidable),
          fmt::to_string(run.excepted),
          fmt::format("{:.2g}", run.kinetic_energy),
          fmt::format("{:.1g}", run.energy_gained),
          fmt::format("{:.2g}", run.energy_lost),
          fmt::format("{:.1g}", run.momentum_gained)};
}

void run(const CrossingsOptions& options) {
  Table table({"scene", "world", "step", "triangles", "at start", "edges", "steps with", "answered", "rounds", "most",
               "held", "unavoidable", "excepted", "energy", "gained", "lost", "momentum"},
              2);
  nlohmann::ordered_json json = describe_run("crossings", options.machine);
  for (const demo::SceneInfo& info : demo::scenes()) {
    const bool is_wanted = (options.scenes.empty() && !info.starts_tangled) ||
                           std::find(options.scenes.begin(), options.scenes.end(), info.name) != options.scenes.end();
    if (!is_wanted) continue;
    for (const demo::World world : options.worlds) {
      if (world == demo::World::deformable && !info.in_deformable_world) continue;
      for (const int steps_per_second : options.steps_per_second) {
        const Run result = simulate(info, world, steps_per_second, options);
        fmt::print(stderr, "{}\n", fmt::join(to_row(result), " "));
        table.add(to_row(result));
        json["crossings"].push_back(to_json(result));
      }
    }
  }
  const std::string report = fmt::format(
      "### Crossings\n\nEdges that intersect triangles, in exact arithmetic: at the start, the most after a step, and "
      "the "
      "steps after which there were any, in {} s of each scene. `answered`: steps in which something would have met; "
      "rounds "
      "of answers in these, mean and most; nodes held in one step, most; pairs that met nonetheless, and that were "
      "excepted, "
      "of all steps. Energy, J: the largest kinetic one, the most that one step's answers added, what all took. "
      "Momentum: the "
      "most that one step's answers added, as a share of sum(m |v|).\n\n{}\n",
      options.seconds, table.text());
  fmt::print("{}", report);
  if (!options.markdown_file.empty()) write_file(options.markdown_file, report);
  if (!options.json_file.empty()) write_json(options.json_file, json);
}

}  // namespace

void add_crossings(CLI::App& app, CrossingsOptions& options) {
  CLI::App* command = app.add_subcommand(
      "crossings",
      "Checks that no step ends with an intersection, with continuous detection and responses to edges: counts edges\n"
      "through triangles after every step of the demo scenes, in exact arithmetic, and what prevention changed");
  command->add_option("--scene", options.scenes, "See softcd-demo --list; several by commas")
      ->option_text("SCENE [all]")
      ->delimiter(',')
      ->check([](const std::string& name) {
        return demo::find_scene(name) != nullptr ? std::string() : "there is no scene '" + name + "'";
      });
  demo::add_choices(*command, "--world", demo::kWorlds, options.worlds, "Bullet's worlds, one after the other");
  command->add_option("--rate", options.steps_per_second, "Steps a second; several by commas")
      ->option_text("N [30,60,120,240]")
      ->delimiter(',')
      ->check(CLI::Range(1, 1000000));
  command->add_option("--seconds", options.seconds, "Simulated seconds of each scene")
      ->option_text("S [2.5]")
      ->check(CLI::Range(0.001, 10000.0));
  command
      ->add_option("--time-limit", options.time_limit,
                   "Seconds of this machine for each run: steps that it has not begun by then are left out")
      ->option_text("S [none]")
      ->check(CLI::PositiveNumber);
  demo::add_choice(*command, "--size", kSizes, options.size,
                   "Size of the scenes; paper: the default for scenes that are not in the paper");
  demo::add_choice(*command, "--contacts", options.contacts, "The contacts that Bullet's solver gets");
  demo::add_choice(*command, "--backend", options.backend, "softcd's backend");
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the table as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure of every run")->option_text("FILE");
  command->callback([&options] { run(options); });
}

}  // namespace softcd::benchmarks

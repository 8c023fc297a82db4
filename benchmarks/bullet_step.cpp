#include "bullet_step.hpp"

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"
#include "ball_heap.hpp"
#include "command_line/choices.hpp"
#include "command_line/stage_times.hpp"
#include "report.hpp"
#include "scenes/two_cloths.hpp"

// What a whole step of Bullet's costs with each way of finding the contacts of its soft bodies. All variants run in one
// process, one step of each in turn, so that what else the machine does falls on all of them.

namespace softcd::benchmarks {
namespace {

using demo::Collision;
using demo::PlugIn;
using demo::SceneOptions;

constexpr std::array<demo::Choice<BulletScene>, 2> kBulletScenes = {
    {{"two-cloths", BulletScene::two_cloths}, {"balls", BulletScene::balls}}};

// Until many bodies touch; Bullet's own detection of the balls is slow.
constexpr int kTwoClothsWarmUp = 90;
constexpr int kBallsWarmUp = 20;

std::unique_ptr<demo::Scene> make_scene(BulletScene scene, const SceneOptions& options) {
  if (scene == BulletScene::balls) return std::make_unique<BallHeap>(options);
  return std::make_unique<demo::TwoCloths>(options);
}

class Variant {
 public:
  Variant(std::string name, Collision collision, PlugIn plug_in, Backend backend, const BulletStepOptions& options)
      : name_(std::move(name)), scene_(make_scene(options.scene, scene_options(collision, plug_in, backend, options))) {
    btCollisionObjectArray& objects = scene_->simulation().world().getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
      if (btSoftBody* body = btSoftBody::upcast(objects[i])) bodies_.push_back(body);
    }
  }

  void step() {
    const auto start = std::chrono::steady_clock::now();
    scene_->step();
    step_ms_.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    if (const CollisionPipeline* pipeline = scene_->simulation().pipeline()) {
      detection_ms_.push_back(pipeline->statistics().ms.total);
    }
    contacts_.push_back(static_cast<double>(scene_->count_contacts()));
  }

  void forget_times() {
    step_ms_.clear();
    detection_ms_.clear();
    contacts_.clear();
  }

  const std::string& name() const { return name_; }
  double last_ms() const { return step_ms_.back(); }
  double median_ms() const { return demo::median(step_ms_); }
  double median_detection_ms() const { return detection_ms_.empty() ? 0 : demo::median(detection_ms_); }
  double median_contacts() const { return demo::median(contacts_); }
  const std::vector<btSoftBody*>& bodies() const { return bodies_; }

  double first_step_ms = 0;

 private:
  static SceneOptions scene_options(Collision collision, PlugIn plug_in, Backend backend,
                                    const BulletStepOptions& options) {
    SceneOptions scene;
    scene.collision = collision;
    scene.plug_in = plug_in;
    scene.settings.backend = backend;
    scene.settings.detection = options.detection;
    scene.nodes_per_side = options.nodes_per_side;
    return scene;
  }

  std::string name_;
  std::unique_ptr<demo::Scene> scene_;
  std::vector<btSoftBody*> bodies_;
  std::vector<double> step_ms_, detection_ms_, contacts_;
};

void copy_motion(const btSoftBody& from, btSoftBody& to) {
  for (int i = 0; i < from.m_nodes.size(); ++i) {
    to.m_nodes[i].m_x = from.m_nodes[i].m_x;
    to.m_nodes[i].m_v = from.m_nodes[i].m_v;
  }
}

/// The step that is left when detection costs nothing: no body asks for contacts, and no tree is kept. Starts each
/// step where the bodies of `original` are.
void step_floor(Variant& floor, Variant& original) {
  for (std::size_t b = 0; b < floor.bodies().size(); ++b) copy_motion(*original.bodies()[b], *floor.bodies()[b]);
  floor.step();
}

std::string heading(const BulletStepOptions& options) {
  const std::string scene = options.scene == BulletScene::balls
                                ? "100 balls of 1280 triangles"
                                : fmt::format("two cloths of {0} x {0} nodes", options.nodes_per_side);
  return fmt::format("{}, {}, medians of {} steps", scene, name_of(demo::kDetections, options.detection),
                     options.measured_steps);
}

std::string table_of(const std::vector<std::unique_ptr<Variant>>& variants) {
  const double native_ms = variants.front()->median_ms();
  Table table({"", "first ms", "step ms", "detection ms", "contacts", "speed-up"}, 1);
  for (const auto& variant : variants) {
    table.add({variant->name(), fmt::format("{:.1f}", variant->first_step_ms),
               fmt::format("{:.2f}", variant->median_ms()), fmt::format("{:.2f}", variant->median_detection_ms()),
               fmt::format("{:.0f}", variant->median_contacts()),
               fmt::format("{:.2f}", native_ms / variant->median_ms())});
  }
  return table.text();
}

nlohmann::ordered_json to_json(const BulletStepOptions& options,
                               const std::vector<std::unique_ptr<Variant>>& variants) {
  nlohmann::ordered_json json = {{"benchmark", "bullet"},
                                 {"scene", name_of(kBulletScenes, options.scene)},
                                 {"nodes_per_side", options.nodes_per_side},
                                 {"warm_up_steps", options.warm_up_steps},
                                 {"measured_steps", options.measured_steps},
                                 {"detection", name_of(demo::kDetections, options.detection)}};
  for (const auto& variant : variants) {
    json["variants"].push_back({{"name", variant->name()},
                                {"first_step_ms", variant->first_step_ms},
                                {"median_step_ms", variant->median_ms()},
                                {"median_detection_ms", variant->median_detection_ms()},
                                {"median_contacts", variant->median_contacts()}});
  }
  return json;
}

std::vector<std::unique_ptr<Variant>> make_variants(const BulletStepOptions& options) {
  std::vector<std::unique_ptr<Variant>> variants;
  const auto add = [&](const std::string& name, Collision collision, PlugIn plug_in, Backend backend) {
    variants.push_back(std::make_unique<Variant>(name, collision, plug_in, backend, options));
  };
  add("Bullet", Collision::bullet, PlugIn::none, Backend::cpu);
  for (const Backend backend : options.backends) {
    const char* name = name_of(demo::kBackends, backend);
    add(fmt::format("softcd dispatcher, {}", name), Collision::softcd, PlugIn::dispatcher, backend);
    add(fmt::format("softcd world, {}", name), Collision::softcd, PlugIn::one_line_world, backend);
  }
  add("floor", Collision::softcd, PlugIn::one_line_world, Backend::cpu);
  for (btSoftBody* body : variants.back()->bodies()) body->m_cfg.collisions &= ~btSoftBody::fCollision::VF_SS;
  return variants;
}

void run(BulletStepOptions options) {
  if (options.warm_up_steps == 0) {
    options.warm_up_steps = options.scene == BulletScene::balls ? kBallsWarmUp : kTwoClothsWarmUp;
  }
  const std::vector<std::unique_ptr<Variant>> variants = make_variants(options);
  Variant& floor = *variants.back();
  Variant& world = *variants[2];

  for (int step = 0; step < options.warm_up_steps + options.measured_steps; ++step) {
    if (step == options.warm_up_steps) {
      for (const auto& variant : variants) variant->forget_times();
    }
    step_floor(floor, world);
    for (const auto& variant : variants) {
      if (variant.get() != &floor) variant->step();
    }
    if (step == 0) {
      for (const auto& variant : variants) variant->first_step_ms = variant->last_ms();
    }
  }
  const std::string table = table_of(variants);
  fmt::print("{}\n\n{}", heading(options), table);
  if (!options.markdown_file.empty()) {
    write_file(options.markdown_file, fmt::format("### Bullet: {}\n\n{}\n", heading(options), table));
  }
  if (!options.json_file.empty()) write_file(options.json_file, to_json(options, variants).dump(2) + "\n");
}

}  // namespace

void add_bullet_step(CLI::App& app, BulletStepOptions& options) {
  CLI::App* command = app.add_subcommand(
      "bullet",
      "A whole step of Bullet's with soft bodies that lie on each other: Bullet's own detection, softcd in\n"
      "two ways, and the floor, a step without detection. softcd on the CPU unless told otherwise");
  demo::add_choice(*command, "--scene", kBulletScenes, options.scene,
                   "Two cloths on each other, or 100 balls of 1280 triangles that drop onto each other");
  command->add_option("--size", options.nodes_per_side, "Nodes a side of each cloth")
      ->option_text("N [100]")
      ->check(CLI::Range(8, 1000));
  command
      ->add_option(
          "--warm-up", options.warm_up_steps,
          fmt::format("Steps of 1/120 second before the measured ones. Left out: {} with cloths, {} with balls",
                      kTwoClothsWarmUp, kBallsWarmUp))
      ->option_text("N")
      ->check(CLI::Range(1, 100000));
  command->add_option("--steps", options.measured_steps, "Measured steps")
      ->option_text("N [60]")
      ->check(CLI::Range(1, 100000));
  demo::add_choices(*command, "--backend", demo::kBackends, options.backends,
                    "Where softcd computes; with several, all are measured");
  demo::add_choice(*command, "--detection", demo::kDetections, options.detection, "softcd's; dcd is Bullet's rule");
  command->add_option("--markdown", options.markdown_file, "Write the table as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure as JSON")->option_text("FILE");
  command->callback([&options] { run(options); });
}

}  // namespace softcd::benchmarks

#include "bullet_step.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>

#include "command_line/choices.hpp"
#include "scenes/two_cloths.hpp"

// What a whole step of Bullet's costs with each way of finding the contacts of two cloths that lie on each other. All
// variants run in one process, one step of each in turn, so that what else the machine does falls on all of them.

namespace softcd::benchmarks {
namespace {

using demo::Collision;
using demo::PlugIn;
using demo::SceneOptions;
using demo::TwoCloths;

class Variant {
 public:
  Variant(std::string name, Collision collision, PlugIn plug_in, const BulletStepOptions& options)
      : name_(std::move(name)), scene_(scene_options(collision, plug_in, options)) {}

  void step() {
    const auto start = std::chrono::steady_clock::now();
    scene_.step();
    step_ms_.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    if (const CollisionPipeline* pipeline = scene_.simulation().pipeline()) {
      detection_ms_.push_back(pipeline->statistics().ms.total);
    }
    contacts_.push_back(static_cast<double>(scene_.count_contacts()));
  }

  void forget_times() {
    step_ms_.clear();
    detection_ms_.clear();
    contacts_.clear();
  }

  const std::string& name() const { return name_; }
  double last_ms() const { return step_ms_.back(); }
  double median_ms() const { return median(step_ms_); }
  double median_detection_ms() const { return detection_ms_.empty() ? 0 : median(detection_ms_); }
  double median_contacts() const { return median(contacts_); }
  TwoCloths& scene() { return scene_; }

  double first_step_ms = 0;

 private:
  static SceneOptions scene_options(Collision collision, PlugIn plug_in, const BulletStepOptions& options) {
    SceneOptions scene;
    scene.collision = collision;
    scene.plug_in = plug_in;
    scene.settings.backend = options.backend;
    scene.settings.detection = options.detection;
    scene.nodes_per_side = options.nodes_per_side;
    return scene;
  }

  static double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }

  std::string name_;
  TwoCloths scene_;
  std::vector<double> step_ms_, detection_ms_, contacts_;
};

void copy_motion(const btSoftBody& from, btSoftBody& to) {
  for (int i = 0; i < from.m_nodes.size(); ++i) {
    to.m_nodes[i].m_x = from.m_nodes[i].m_x;
    to.m_nodes[i].m_v = from.m_nodes[i].m_v;
  }
}

/// The step that is left when detection costs nothing: no body asks for contacts, and no tree is kept. Starts each
/// step where the cloths of `original` are.
void step_floor(Variant& floor, Variant& original) {
  copy_motion(original.scene().upper(), floor.scene().upper());
  copy_motion(original.scene().lower(), floor.scene().lower());
  floor.step();
}

void print_table(const std::vector<Variant*>& variants) {
  const double native_ms = variants.front()->median_ms();
  fmt::print("{:<20} {:>10} {:>10} {:>13} {:>10} {:>9}\n", "", "first ms", "step ms", "detection ms", "contacts",
             "speed-up");
  for (const Variant* variant : variants) {
    fmt::print("{:<20} {:>10.1f} {:>10.2f} {:>13.2f} {:>10.0f} {:>9.2f}\n", variant->name(), variant->first_step_ms,
               variant->median_ms(), variant->median_detection_ms(), variant->median_contacts(),
               native_ms / variant->median_ms());
  }
}

void write_json(const BulletStepOptions& options, const std::vector<Variant*>& variants) {
  nlohmann::ordered_json json = {{"benchmark", "bullet"},
                                 {"nodes_per_side", options.nodes_per_side},
                                 {"warm_up_steps", options.warm_up_steps},
                                 {"measured_steps", options.measured_steps},
                                 {"backend", name_of(demo::kBackends, options.backend)},
                                 {"detection", name_of(demo::kDetections, options.detection)}};
  for (const Variant* variant : variants) {
    json["variants"].push_back({{"name", variant->name()},
                                {"first_step_ms", variant->first_step_ms},
                                {"median_step_ms", variant->median_ms()},
                                {"median_detection_ms", variant->median_detection_ms()},
                                {"median_contacts", variant->median_contacts()}});
  }
  std::ofstream stream(options.json_file);
  stream << json.dump(2) << "\n";
  stream.close();
  if (!stream) throw std::runtime_error(options.json_file + ": cannot be written (does its folder exist?)");
}

void run(const BulletStepOptions& options) {
  Variant native("Bullet", Collision::bullet, PlugIn::none, options);
  Variant dispatcher("softcd dispatcher", Collision::softcd, PlugIn::dispatcher, options);
  Variant world("softcd world", Collision::softcd, PlugIn::one_line_world, options);
  Variant floor("floor", Collision::softcd, PlugIn::one_line_world, options);
  for (btSoftBody* body : {&floor.scene().upper(), &floor.scene().lower()}) {
    body->m_cfg.collisions &= ~btSoftBody::fCollision::VF_SS;
  }
  const std::vector<Variant*> variants = {&native, &dispatcher, &world, &floor};

  for (int step = 0; step < options.warm_up_steps + options.measured_steps; ++step) {
    if (step == options.warm_up_steps) {
      for (Variant* variant : variants) variant->forget_times();
    }
    native.step();
    dispatcher.step();
    step_floor(floor, world);
    world.step();
    if (step == 0) {
      for (Variant* variant : variants) variant->first_step_ms = variant->last_ms();
    }
  }
  fmt::print("two cloths of {0} x {0} nodes, {1}, medians of {2} steps\n", options.nodes_per_side,
             name_of(demo::kDetections, options.detection), options.measured_steps);
  print_table(variants);
  if (!options.json_file.empty()) write_json(options, variants);
}

}  // namespace

void add_bullet_step(CLI::App& app, BulletStepOptions& options) {
  CLI::App* command = app.add_subcommand(
      "bullet",
      "A whole step of Bullet's with two cloths that lie on each other: Bullet's own detection, softcd in\n"
      "two ways, and the floor, a step without detection. softcd on the CPU unless told otherwise");
  command->add_option("--size", options.nodes_per_side, "Nodes a side of each cloth")
      ->option_text("N [100]")
      ->check(CLI::Range(8, 1000));
  command->add_option("--warm-up", options.warm_up_steps, "Steps of 1/120 second before the measured ones")
      ->option_text("N [90]")
      ->check(CLI::Range(1, 100000));
  command->add_option("--steps", options.measured_steps, "Measured steps")
      ->option_text("N [60]")
      ->check(CLI::Range(1, 100000));
  demo::add_choice(*command, "--backend", demo::kBackends, options.backend, "Where softcd computes");
  demo::add_choice(*command, "--detection", demo::kDetections, options.detection, "softcd's; dcd is Bullet's rule");
  command->add_option("--json", options.json_file, "Write every figure as JSON")->option_text("FILE");
  command->callback([&options] { run(options); });
}

}  // namespace softcd::benchmarks

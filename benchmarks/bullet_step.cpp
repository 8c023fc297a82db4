#include "bullet_step.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "command_line/stage_times.hpp"
#include "command_line/world_choices.hpp"
#include "report.hpp"
#include "scenes/step_profile.hpp"

// Measures a whole step of Bullet with different detectors of soft contacts. All variants run in one process, one step
// of each in turn, so that other load on the machine affects all of them.

namespace softcd::benchmarks {
namespace {

using demo::PlugIn;

constexpr std::array<demo::Choice<BulletScene>, 5> kBulletScenes = {{{"two-cloths", BulletScene::two_cloths},
                                                                     {"balls", BulletScene::balls},
                                                                     {"draped", BulletScene::draped},
                                                                     {"crumpling", BulletScene::crumpling},
                                                                     {"stacked", BulletScene::stacked}}};

struct Heights {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -std::numeric_limits<double>::infinity();
};

class Variant {
 public:
  Variant(std::string name, PlugIn plug_in, Backend backend, bullet::Contacts contacts,
          const BulletStepOptions& options)
      : name_(std::move(name)), world_(options.world, plug_in, settings(backend, contacts, options)) {
    fill(world_, options.scene, options.size);
  }

  /// Makes a step, and measures it and softcd's part of it.
  void step(demo::StepProfiler& profiler) {
    profiler.take();
    const auto start = std::chrono::steady_clock::now();
    world_.step();
    step_ms_.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    our_ms_.push_back(profiler.take().total());
    if (world_.detection() != nullptr)
      detection_ms_.push_back(world_.detection()->contact_report().statistics().ms.total);
    soft_contacts_.push_back(static_cast<double>(world_.count_soft_contacts()));
    rigid_contacts_.push_back(static_cast<double>(world_.count_rigid_contacts()));
  }

  void forget_times() {
    step_ms_.clear();
    our_ms_.clear();
    detection_ms_.clear();
    soft_contacts_.clear();
    rigid_contacts_.clear();
  }

  const std::string& name() const { return name_; }
  SoftWorld& world() { return world_; }
  double last_ms() const { return step_ms_.back(); }
  double median_ms() const { return demo::median(step_ms_); }
  double median_our_ms() const { return demo::median(our_ms_); }
  /// Returns the median of the time of each step without softcd's part, minus the time of `floor`'s step in the same
  /// turn.
  double median_answer_ms(const Variant& floor) const {
    std::vector<double> answer_ms;
    for (std::size_t i = 0; i < step_ms_.size(); ++i) {
      answer_ms.push_back(step_ms_[i] - our_ms_[i] - floor.step_ms_[i]);
    }
    return demo::median(answer_ms);
  }
  bool has_detection_ms() const { return !detection_ms_.empty(); }
  double median_detection_ms() const { return demo::median(detection_ms_); }
  double median_soft_contacts() const { return demo::median(soft_contacts_); }
  double median_rigid_contacts() const { return demo::median(rigid_contacts_); }

  /// Returns the heights of the nodes. Throws when a position is not finite: the times then mean nothing.
  Heights heights() const {
    Heights heights;
    for (const btSoftBody* body : world_.bodies()) {
      for (int i = 0; i < body->m_nodes.size(); ++i) {
        const btVector3& x = body->m_nodes[i].m_x;
        if (!std::isfinite(x.length2())) throw std::runtime_error(name_ + ": the simulation is unstable");
        heights.lowest = std::min(heights.lowest, double(x.y()));
        heights.highest = std::max(heights.highest, double(x.y()));
      }
    }
    return heights;
  }

  double first_step_ms = 0;

 private:
  static bullet::Settings settings(Backend backend, bullet::Contacts contacts, const BulletStepOptions& options) {
    bullet::Settings settings;
    settings.backend = backend;
    settings.contacts = contacts;
    settings.detection = options.detection;
    return settings;
  }

  std::string name_;
  SoftWorld world_;
  std::vector<double> step_ms_, our_ms_, detection_ms_, soft_contacts_, rigid_contacts_;
};

struct Comparison {
  std::unique_ptr<Variant> native;  ///< null: left out
  std::vector<std::unique_ptr<Variant>> ours;
  std::unique_ptr<Variant> floor;
  Variant* original = nullptr;  ///< of `ours`, whose steps the floor takes

  /// Returns whether the variant's steps are reported in three parts.
  bool is_ours(const Variant& variant) const { return &variant != native.get() && &variant != floor.get(); }

  std::vector<Variant*> all() const {
    std::vector<Variant*> variants;
    if (native != nullptr) variants.push_back(native.get());
    for (const auto& variant : ours) variants.push_back(variant.get());
    variants.push_back(floor.get());
    return variants;
  }
};

void copy_motion(const btSoftBody& from, btSoftBody& to) {
  for (int i = 0; i < from.m_nodes.size(); ++i) {
    to.m_nodes[i].m_x = from.m_nodes[i].m_x;
    to.m_nodes[i].m_v = from.m_nodes[i].m_v;
    to.m_nodes[i].m_q = from.m_nodes[i].m_q;
    to.m_nodes[i].m_vn = from.m_nodes[i].m_vn;
  }
}

/// Makes a step as if detection cost nothing: no body has soft contacts, and no tree is kept for them. Starts each step
/// from the positions of `original`.
void step_floor(Variant& floor, Variant& original, demo::StepProfiler& profiler) {
  const std::vector<btSoftBody*>& from = original.world().bodies();
  const std::vector<btSoftBody*>& to = floor.world().bodies();
  for (std::size_t b = 0; b < to.size(); ++b) copy_motion(*from[b], *to[b]);
  floor.step(profiler);
}

int faces_of_largest_body(const SoftWorld& world) {
  int most = 0;
  for (const btSoftBody* body : world.bodies()) most = std::max(most, body->m_faces.size());
  return most;
}

Comparison make_comparison(const BulletStepOptions& options) {
  Comparison comparison;
  const auto make = [&](const std::string& name, PlugIn plug_in, Backend backend,
                        bullet::Contacts contacts = bullet::Contacts::all) {
    return std::make_unique<Variant>(name, plug_in, backend, contacts, options);
  };
  comparison.floor = make("floor", PlugIn::one_line_world, Backend::cpu);
  comparison.floor->world().stop_soft_contacts();
  if (faces_of_largest_body(comparison.floor->world()) <= options.most_native_faces) {
    comparison.native = make("Bullet", PlugIn::none, Backend::cpu);
  }
  for (const Backend backend : options.backends) {
    for (const bullet::Contacts contacts : options.contacts) {
      std::string how = demo::name_of(backend);
      if (contacts != bullet::Contacts::all) how += fmt::format(", {}", demo::name_of(contacts));
      if (options.world == World::classic) {
        comparison.ours.push_back(make("softcd dispatcher, " + how, PlugIn::dispatcher, backend, contacts));
      }
      comparison.ours.push_back(make("softcd world, " + how, PlugIn::one_line_world, backend, contacts));
      if (comparison.original == nullptr) comparison.original = comparison.ours.back().get();
    }
  }
  return comparison;
}

std::string heading(const BulletStepOptions& options, const SoftWorld& world) {
  int triangles = 0;
  for (const btSoftBody* body : world.bodies()) triangles += body->m_faces.size();
  const std::size_t count = world.bodies().size();
  return fmt::format("{}, {} {} of {} triangles in all, {} world, {}, medians of {} steps",
                     name_of(kBulletScenes, options.scene), count, count == 1 ? "body" : "bodies", triangles,
                     name_of(demo::kWorlds, options.world), demo::name_of(options.detection), options.measured_steps);
}

/// Returns remarks that explain the figures.
std::string remarks(const BulletStepOptions& options, const Comparison& comparison) {
  std::string text;
  if (comparison.native == nullptr) {
    text += fmt::format("Bullet's own detection is left out: a body has more than {} faces.\n\n",
                        options.most_native_faces);
  }
  const bool touches_itself = options.scene == BulletScene::crumpling || options.scene == BulletScene::stacked;
  if (options.world == World::classic && touches_itself) {
    text += "Bullet's own detection finds no contacts within a body in the classic world.\n\n";
  }
  return text;
}

std::string table_of(const Comparison& comparison) {
  Table table({"", "first ms", "step ms", "answer ms", "ours ms", "detection ms", "soft contacts", "rigid contacts",
               "speed-up", "step/floor"},
              1);
  const Variant& floor = *comparison.floor;
  for (const Variant* variant : comparison.all()) {
    table.add(
        {variant->name(), fmt::format("{:.1f}", variant->first_step_ms), fmt::format("{:.2f}", variant->median_ms()),
         comparison.is_ours(*variant) ? fmt::format("{:.2f}", variant->median_answer_ms(floor)) : "",
         comparison.is_ours(*variant) ? fmt::format("{:.2f}", variant->median_our_ms()) : "",
         variant->has_detection_ms() ? fmt::format("{:.2f}", variant->median_detection_ms()) : "",
         fmt::format("{:.0f}", variant->median_soft_contacts()),
         fmt::format("{:.0f}", variant->median_rigid_contacts()),
         comparison.native != nullptr ? fmt::format("{:.2f}", comparison.native->median_ms() / variant->median_ms())
                                      : "",
         fmt::format("{:.2f}", variant->median_ms() / floor.median_ms())});
  }
  return table.text();
}

nlohmann::ordered_json to_json(const BulletStepOptions& options, const Comparison& comparison) {
  nlohmann::ordered_json json = describe_run("bullet", options.machine);
  json.update({{"scene", name_of(kBulletScenes, options.scene)},
               {"world", name_of(demo::kWorlds, options.world)},
               {"size", options.size},
               {"warm_up_steps", options.warm_up_steps},
               {"measured_steps", options.measured_steps},
               {"detection", demo::name_of(options.detection)}});
  for (const Variant* variant : comparison.all()) {
    const Heights heights = variant->heights();
    nlohmann::ordered_json row = {
        {"name", variant->name()}, {"first_step_ms", variant->first_step_ms}, {"median_step_ms", variant->median_ms()}};
    if (variant->has_detection_ms()) row["median_detection_ms"] = variant->median_detection_ms();
    if (comparison.is_ours(*variant)) {
      row["median_answer_ms"] = variant->median_answer_ms(*comparison.floor);
      row["median_our_ms"] = variant->median_our_ms();
    }
    row["median_soft_contacts"] = variant->median_soft_contacts();
    row["median_rigid_contacts"] = variant->median_rigid_contacts();
    row["lowest_node"] = heights.lowest;
    row["highest_node"] = heights.highest;
    json["variants"].push_back(row);
  }
  return json;
}

void run(BulletStepOptions options) {
  if (options.warm_up_steps == 0) options.warm_up_steps = default_warm_up(options.scene, options.world);
  const Comparison comparison = make_comparison(options);
  const std::vector<Variant*> variants = comparison.all();
  demo::StepProfiler profiler;

  for (int step = 0; step < options.warm_up_steps + options.measured_steps; ++step) {
    if (step == options.warm_up_steps) {
      for (Variant* variant : variants) variant->forget_times();
    }
    step_floor(*comparison.floor, *comparison.original, profiler);
    for (Variant* variant : variants) {
      if (variant != comparison.floor.get()) variant->step(profiler);
    }
    if (step == 0) {
      for (Variant* variant : variants) variant->first_step_ms = variant->last_ms();
    }
  }
  for (const Variant* variant : variants) variant->heights();
  const std::string title = heading(options, comparison.floor->world());
  const std::string tables = remarks(options, comparison) + table_of(comparison);
  fmt::print("{}\n\n{}", title, tables);
  if (!options.markdown_file.empty()) {
    write_file(options.markdown_file, fmt::format("### Bullet: {}\n\n{}\n", title, tables));
  }
  if (!options.json_file.empty()) write_json(options.json_file, to_json(options, comparison));
}

}  // namespace

void add_bullet_step(CLI::App& app, BulletStepOptions& options) {
  CLI::App* command = app.add_subcommand(
      "bullet",
      "Measures a whole step of Bullet's with soft bodies: with Bullet's own detection, with softcd (by default on\n"
      "the CPU), and as the floor. The floor is softcd's step without contacts between soft bodies: they are neither\n"
      "detected nor solved, and no tree is kept for them. Each of its steps starts where softcd's does. A step with\n"
      "softcd is reported in three parts: the floor, the solver's time for the contacts, and softcd's time, in which\n"
      "contacts are found, written for Bullet, and crossings are prevented");
  demo::add_choice(*command, "--scene", kBulletScenes, options.scene,
                   "two-cloths: one falls onto another that is held along its border; balls: of 1280\n"
                   "triangles each, which drop onto each other; draped: a cloth over rigid balls;\n"
                   "crumpling: a cloth that sinks into a heap; stacked: two cloths that touch themselves lie\n"
                   "on each other, with --size 29 a small scene for one core (taskset -c 0)");
  demo::add_choice(*command, "--world", demo::kWorlds, options.world,
                   "Bullet's classic soft world in steps of 1/120 second, with softcd in two ways, or its\n"
                   "deformable world in steps of 1/240, where springs are integrated explicitly");
  command
      ->add_option("--size", options.size,
                   "Nodes a side of each cloth, 101 for 20,000 triangles and 213 for 90,000; or the\n"
                   "number of balls")
      ->option_text("N [100]")
      ->check(CLI::Range(8, 1000));
  command
      ->add_option("--warm-up", options.warm_up_steps,
                   "Steps before the measured ones. Default: until many nodes touch something")
      ->option_text("N")
      ->check(CLI::Range(1, 100000));
  command->add_option("--steps", options.measured_steps, "Measured steps")
      ->option_text("N [60]")
      ->check(CLI::Range(1, 100000));
  command
      ->add_option("--most-native-faces", options.most_native_faces,
                   "Skip Bullet's own detection where a body has more faces: its first step takes time\n"
                   "quadratic in them, 30 s with 90,000")
      ->option_text("N [50000]")
      ->check(CLI::NonNegativeNumber);
  demo::add_choices(*command, "--backend", options.backends, "softcd's backend; with several, all are measured");
  demo::add_choice(*command, "--detection", options.detection, "softcd's detection; dcd is Bullet's rule");
  demo::add_choices(*command, "--contacts", options.contacts,
                    "The contacts that softcd gives to Bullet's solver; with several, all are measured");
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the table as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure as JSON")->option_text("FILE");
  command->callback([&options] { run(options); });
}

}  // namespace softcd::benchmarks

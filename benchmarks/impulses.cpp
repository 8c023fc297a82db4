#include "impulses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "app_list.hpp"
#include "report.hpp"
#include "scenes/cloth.hpp"
#include "scenes/soft_ball.hpp"

// Compares the impulses that softcd reports on a soft body with the body's change of momentum.

namespace softcd::benchmarks {
namespace {

/// A soft body whose impulses are compared with its momentum, and how the app moves others.
struct Subject {
  btSoftBody* body = nullptr;
  AppDrive drive;
};

struct SetUp {
  const char* name;
  AppWorldKind world;
  double warm_up;  ///< seconds before the comparison
  bool falls_asleep;
  Subject (*build)(AppWorld& world);
};

demo::ClothShape held_cloth() {
  demo::ClothShape shape = demo::horizontal_cloth(15, 2, 0);
  shape.is_fixed = [](int column, int row) { return column == 0 || row == 0 || column == 14 || row == 14; };
  return shape;
}

btSoftBody& add_cloth(AppWorld& world, const demo::ClothShape& shape) {
  auto cloth = demo::make_cloth(world.info(), shape, 1);
  cloth->getCollisionShape()->setMargin(btScalar(0.03));
  cloth->m_cfg.kDF = btScalar(0.5);
  cloth->m_cfg.kDP = btScalar(0.01);
  return world.add(std::move(cloth));
}

Subject build_gripper(AppWorld& world) {
  const auto app =
      std::find_if(apps().begin(), apps().end(), [](const App& a) { return a.name == std::string("gripper"); });
  AppDrive drive = app->build(world);
  return {world.soft_world().bodies()[0], std::move(drive)};
}

Subject build_ball(AppWorld& world) {
  add_cloth(world, held_cloth());
  return {&world.add(demo::make_soft_ball(world.soft_world(), {btVector3(0, btScalar(0.4), 0), btScalar(0.3),
                                                               /*subdivisions=*/2, /*mass=*/1,
                                                               /*margin=*/btScalar(0.03)})),
          {}};
}

Subject build_cloth_on_box(AppWorld& world) {
  world.add_rigid(std::make_unique<btBoxShape>(btVector3(3, 1, 3)), btVector3(0, -1, 0)).setFriction(1);
  return {&add_cloth(world, demo::horizontal_cloth(9, 1, btScalar(0.05))), {}};
}

Subject build_rope(AppWorld& world) {
  add_cloth(world, held_cloth());
  std::vector<btVector3> nodes;
  for (int i = 0; i <= 20; ++i) nodes.emplace_back(btScalar(0.06) * btScalar(i - 10), btScalar(0.1), btScalar(0.03));
  auto rope = std::make_unique<btSoftBody>(&world.info(), static_cast<int>(nodes.size()), nodes.data(), nullptr);
  for (int i = 1; i < rope->m_nodes.size(); ++i) rope->appendLink(i - 1, i);
  rope->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  rope->m_cfg.kDP = btScalar(0.05);
  rope->m_cfg.kDF = btScalar(0.5);
  rope->getCollisionShape()->setMargin(btScalar(0.03));
  rope->setTotalMass(btScalar(0.2));
  return {&world.add(std::move(rope)), {}};
}

const std::vector<SetUp>& set_ups() {
  static const std::vector<SetUp> list = {
      {"gripper", AppWorldKind::soft_rigid, 1, false, build_gripper},
      {"gripper", AppWorldKind::deformable, 1, false, build_gripper},
      {"ball at rest on a held cloth", AppWorldKind::soft_rigid, 3, false, build_ball},
      {"ball at rest on a held cloth", AppWorldKind::deformable, 3, false, build_ball},
      {"cloth on a box", AppWorldKind::soft_rigid, 3, false, build_cloth_on_box},
      {"cloth on a box", AppWorldKind::deformable, 3, false, build_cloth_on_box},
      {"sleeping cloth on a box", AppWorldKind::deformable, 3, true, build_cloth_on_box},
      {"rope on a held cloth", AppWorldKind::soft_rigid, 3, false, build_rope},
  };
  return list;
}

btVector3 sum_of(const btSoftBody& body, btVector3 btSoftBody::Node::*vector) {
  btVector3 sum(0, 0, 0);
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    if (body.m_nodes[i].m_im > 0) sum += body.m_nodes[i].*vector / body.m_nodes[i].m_im;
  }
  return sum;
}

btVector3 given_to(const btSoftBody& body, const std::vector<bullet::BodyPairContacts>& pairs) {
  btVector3 sum(0, 0, 0);
  for (const bullet::BodyPairContacts& pair : pairs) {
    if (pair.a == &body) sum += pair.impulse_a;
    if (pair.b == &body) sum += pair.impulse_b;
  }
  return sum;
}

struct ImpulseResult {
  btVector3 read{0, 0, 0};    ///< mean force by the reported impulses, N
  btVector3 needed{0, 0, 0};  ///< mean force by the change of momentum and gravity, N
  bool is_asleep = false;

  double difference() const { return double((read - needed).length() / needed.length()); }
};

ImpulseResult compare(const SetUp& set_up, bullet::Settings settings) {
  settings.read_out = bullet::ReadOut::impulses;
  settings.edge_contacts = bullet::EdgeContacts::respond;
  AppWorld world(set_up.world, settings, /*iterations=*/4);
  const Subject subject = set_up.build(world);
  btSoftBody& body = *subject.body;
  if (set_up.falls_asleep) body.forceActivationState(ACTIVE_TAG);
  const btScalar seconds = AppWorld::kFrame / btScalar(world.steps_per_frame());
  const btScalar end = btScalar(set_up.warm_up + 1);
  btScalar mass = 0;
  for (int i = 0; i < body.m_nodes.size(); ++i) mass += 1 / body.m_nodes[i].m_im;
  ImpulseResult result;
  btScalar compared = 0;
  for (int step = 1; btScalar(step) * seconds <= end; ++step) {
    if (subject.drive) subject.drive(btScalar(step) * seconds, seconds);
    const btVector3 momentum = sum_of(body, &btSoftBody::Node::m_v);
    const btVector3 places = sum_of(body, &btSoftBody::Node::m_x);
    world.step(seconds);
    if (btScalar(step) * seconds <= btScalar(set_up.warm_up)) continue;
    // In classic worlds contacts of later bodies may move nodes after Bullet has computed their velocities.
    const btVector3 momentum_at_end = world.is_deformable() ? sum_of(body, &btSoftBody::Node::m_v)
                                                            : (sum_of(body, &btSoftBody::Node::m_x) - places) / seconds;
    result.needed += momentum_at_end - momentum - mass * world.info().m_gravity * seconds;
    result.read += given_to(body, world.soft_world().detection()->body_contacts());
    compared += seconds;
  }
  result.needed /= compared;
  result.read /= compared;
  result.is_asleep = !body.isActive();
  return result;
}

void run(const ImpulsesOptions& options) {
  Table table({"set-up", "world", "detection", "read N", "needed N", "difference %"}, 3);
  nlohmann::ordered_json json = describe_run("impulses", options.machine);
  for (const SetUp& set_up : set_ups()) {
    for (const Detection detection : {Detection::dcd, Detection::ccd}) {
      bullet::Settings settings;
      settings.backend = Backend::cpu;
      settings.detection = detection;
      const ImpulseResult result = compare(set_up, settings);
      const std::string world = set_up.world == AppWorldKind::deformable ? "deformable" : "soft-rigid";
      const std::string name = detection == Detection::dcd ? "dcd" : "ccd";
      table.add({set_up.name, world, name, fmt::format("{:.4f}", result.read.length()),
                 fmt::format("{:.4f}", result.needed.length()), fmt::format("{:.3f}", 100 * result.difference())});
      json["impulses"].push_back({{"set_up", set_up.name},
                                  {"world", world},
                                  {"detection", name},
                                  {"read", result.read.length()},
                                  {"needed", result.needed.length()},
                                  {"difference", result.difference()},
                                  {"is_asleep", result.is_asleep}});
    }
  }
  const std::string report = fmt::format(
      "### Impulses\n\nMean force on a soft body over 1 s: by the impulses that softcd reports, and needed for its "
      "weight and its change of momentum. Difference of the vectors.\n\n{}\n",
      table.text());
  fmt::print("{}", report);
  if (!options.markdown_file.empty()) write_file(options.markdown_file, report);
  if (!options.json_file.empty()) write_json(options.json_file, json);
}

}  // namespace

void add_impulses(CLI::App& app, ImpulsesOptions& options) {
  CLI::App* command = app.add_subcommand(
      "impulses", "Compares the impulses that softcd reports on soft bodies with their changes of momentum");
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the table as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure")->option_text("FILE");
  command->callback([&options] { run(options); });
}

}  // namespace softcd::benchmarks

#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "LinearMath/btThreads.h"
#include "backend_under_test.hpp"
#include "scenes/cloth.hpp"
#include "scenes/simulation.hpp"

namespace softcd::test {

inline constexpr btScalar kStep = btScalar(1) / 60;

/// Every way in which softcd is plugged into a classic soft world.
inline const std::vector<demo::PlugIn> kPlugIns = {demo::PlugIn::one_line_world, demo::PlugIn::multi_body_world,
                                                   demo::PlugIn::dispatcher, demo::PlugIn::attached};

inline std::string name_of(demo::PlugIn plug_in) {
  switch (plug_in) {
    case demo::PlugIn::none:
      return "none";
    case demo::PlugIn::none_multi_body:
      return "none_multi_body";
    case demo::PlugIn::one_line_world:
      return "one_line_world";
    case demo::PlugIn::multi_body_world:
      return "multi_body_world";
    case demo::PlugIn::dispatcher:
      return "dispatcher";
    case demo::PlugIn::attached:
      return "attached";
  }
  return "?";
}

/// Names parameterised tests.
inline std::string plug_in_name(const testing::TestParamInfo<demo::PlugIn>& parameter) {
  return name_of(parameter.param);
}

/// With the contacts of Bullet's own rules, which tests compare with Bullet's and with exact ones.
inline bullet::Settings settings_on(Backend backend, Detection detection) {
  bullet::Settings settings;
  settings.backend = backend;
  settings.detection = detection;
  settings.edge_contacts = bullet::EdgeContacts::off;
  settings.contacts = bullet::Contacts::all;
  return settings;
}

/// Returns the settings of tests that run on every backend.
inline bullet::Settings test_settings(Detection detection = Detection::dcd) {
  return settings_on(backend_under_test(), detection);
}

/// Returns the settings of tests about the bodies and worlds of apps, which do not depend on the backend.
inline bullet::Settings cpu_settings(Detection detection = Detection::dcd) {
  return settings_on(Backend::cpu, detection);
}

/// Settings with which nothing passes through anything, with Detection::ccd.
inline bullet::Settings careful_settings(Detection detection = Detection::ccd) {
  bullet::Settings settings = cpu_settings(detection);
  settings.edge_contacts = bullet::EdgeContacts::respond;
  return settings;
}

/// For btCollisionDispatcherMt, which requires a scheduler: threads, where Bullet was built with BT_THREADSAFE.
inline void set_task_scheduler() {
  static btITaskScheduler* const threads = btCreateDefaultTaskScheduler();  // none where it was not
  btSetTaskScheduler(threads != nullptr ? threads : btGetSequentialTaskScheduler());
}

struct SheetOptions {
  int nodes_per_side = 9;
  btScalar side = 1;
  btScalar height = 0;
  btScalar margin = btScalar(0.05);
  bool fixed = false;  ///< all nodes
};

/// A horizontal sheet of one kilogram.
inline std::unique_ptr<btSoftBody> make_sheet(btSoftBodyWorldInfo& world_info, const SheetOptions& options) {
  demo::ClothShape shape = demo::horizontal_cloth(options.nodes_per_side, options.side, options.height);
  if (options.fixed) shape.is_fixed = [](int, int) { return true; };
  auto sheet = demo::make_cloth(world_info, shape, 1);
  sheet->getCollisionShape()->setMargin(options.margin);
  sheet->m_cfg.kDP = btScalar(0.02);
  sheet->m_cfg.piterations = 4;
  return sheet;
}

inline btScalar kinetic_energy(const btSoftBody& body) {
  btScalar energy = 0;
  for (int n = 0; n < body.m_nodes.size(); ++n) {
    const btSoftBody::Node& node = body.m_nodes[n];
    if (node.m_im > 0) energy += node.m_v.length2() / (2 * node.m_im);
  }
  return energy;
}

inline btScalar mean_height(const btSoftBody& body) {
  btScalar sum = 0;
  for (int i = 0; i < body.m_nodes.size(); ++i) sum += body.m_nodes[i].m_x.y();
  return sum / btScalar(body.m_nodes.size());
}

inline btScalar lowest_height(const btSoftBody& body) {
  btScalar lowest = body.m_nodes[0].m_x.y();
  for (int i = 0; i < body.m_nodes.size(); ++i) lowest = btMin(lowest, body.m_nodes[i].m_x.y());
  return lowest;
}

}  // namespace softcd::test

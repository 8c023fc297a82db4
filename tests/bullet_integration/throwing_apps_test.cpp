// Apps whose callbacks or allocator throw in the middle of a step. Bullet promises nothing then. softcd restores all
// state that it has replaced, bodies may leave, and the next step is as usual.

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "BulletCollision/CollisionDispatch/btManifoldResult.h"
#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "LinearMath/btAlignedAllocator.h"
#include "any_simulation.hpp"
#include "interruption.hpp"

namespace softcd::test {
namespace {

/// An exception of the app, not one of the standard library.
struct OfTheApp {};

/// All that there is to be given back of a body: its flags, and the leaves of its tree of nodes.
struct BodyState {
  int flags;
  bool soft_soft_collision;
  int leaves;

  friend bool operator==(const BodyState&, const BodyState&) = default;
};
std::ostream& operator<<(std::ostream& out, const BodyState& state) {
  return out << "flags " << state.flags << (state.soft_soft_collision ? ", soft-soft, " : ", ") << state.leaves
             << " leaves";
}

/// -1 where one is not in the tree.
int count_leaves(const btSoftBody& body) {
  for (int n = 0; n < body.m_nodes.size(); ++n) {
    const btDbvtNode* node = body.m_nodes[n].m_leaf;
    if (node == nullptr || node->data != &body.m_nodes[n]) return -1;
    while (node->parent != nullptr) node = node->parent;
    if (node != body.m_ndbvt.m_root) return -1;
  }
  return body.m_nodes.size();
}

BodyState state_of(const btSoftBody& body) {
  return {body.m_cfg.collisions, body.m_softSoftCollision, count_leaves(body)};
}

/// Returns the create function of algorithms for pairs of these shapes.
const btCollisionAlgorithmCreateFunc* algorithm(btCollisionDispatcher& dispatcher, int type0, int type1) {
  struct Table : btCollisionDispatcher {
    static const btCollisionAlgorithmCreateFunc* entry(btCollisionDispatcher& of, int a, int b) {
      return (of.*&Table::m_doubleDispatchContactPoints)[a][b];
    }
  };
  return Table::entry(dispatcher, type0, type1);
}

/// A sheet on another one, which is held, and one on a rigid mesh and a box; two rigid boxes on each other.
class App {
 public:
  explicit App(World world, bullet::Settings settings = everything()) : simulation(world, settings) {
    ground_.addTriangle(btVector3(-30, -2, -30), btVector3(0, -2, 60), btVector3(30, -2, -30));
    simulation.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&ground_, true), btVector3(0, 0, 0));
    const btVector3 half(btScalar(0.3), btScalar(0.3), btScalar(0.3));
    for (const btScalar height : {btScalar(-1.7), btScalar(-1.1)}) {
      btRigidBody& box = simulation.add_rigid(std::make_unique<btBoxShape>(half), btVector3(5, height, 0), 1);
      box.setCollisionFlags(box.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    }
    add(0, 0, true);
    add(btScalar(0.1), 0, false);
    add(btScalar(-0.75), 5, false);
    for (int i = 0; i < 10; ++i) simulation.step();
  }

  static bullet::Settings everything() {
    bullet::Settings settings = careful_settings();
    settings.convex_shapes = bullet::ConvexShapes::faces_and_edges;
    settings.read_out = bullet::ReadOut::impulses;
    return settings;
  }

  std::vector<BodyState> states() const {
    std::vector<BodyState> states;
    for (const btSoftBody* body : bodies) states.push_back(state_of(*body));
    return states;
  }
  std::array<const btCollisionAlgorithmCreateFunc*, 4> algorithms() {
    auto& dispatcher = static_cast<btCollisionDispatcher&>(*simulation.world().getDispatcher());
    return {algorithm(dispatcher, SOFTBODY_SHAPE_PROXYTYPE, TRIANGLE_MESH_SHAPE_PROXYTYPE),
            algorithm(dispatcher, TRIANGLE_MESH_SHAPE_PROXYTYPE, SOFTBODY_SHAPE_PROXYTYPE),
            algorithm(dispatcher, SOFTBODY_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE),
            algorithm(dispatcher, BOX_SHAPE_PROXYTYPE, SOFTBODY_SHAPE_PROXYTYPE)};
  }
  /// Whether the two sheets touch within a second, and nothing has failed on the way.
  bool goes_on() {
    bool touches = false;
    for (int i = 0; i < 60 && !touches; ++i) {
      simulation.step();
      for (const bullet::BodyPairContacts& pair : simulation.detection().body_contacts()) {
        touches |= (pair.a == bodies[0] && pair.b == bodies[1]) || (pair.a == bodies[1] && pair.b == bodies[0]);
      }
    }
    const bullet::WorldDetection& detection = simulation.detection();
    return touches && detection.contact_report().failed_steps() == 0 &&
           detection.crossing_report().failed_steps() == 0 && detection.rigid_mesh_report().failed_steps() == 0 &&
           detection.convex_shape_report().failed_steps() == 0;
  }

 private:
  void add(btScalar height, btScalar x, bool fixed) {
    SheetOptions options;
    options.nodes_per_side = 5;
    options.height = height;
    options.fixed = fixed;
    std::unique_ptr<btSoftBody> sheet = make_sheet(simulation.world_info(), options);
    sheet->translate(btVector3(x, 0, 0));
    sheet->setActivationState(DISABLE_DEACTIVATION);
    bodies.push_back(&simulation.add(std::move(sheet)));
  }

  btTriangleMesh ground_;

 public:
  AnySimulation simulation;
  std::vector<btSoftBody*> bodies;  ///< held, falling, on the box
};

enum class Where {
  before_tick,
  after_tick,
  in_action,
  near_callback,
  pair_filter,
  contact_added,
  on_contacts,
  log,
};

std::string name_of(Where where) {
  constexpr std::array kNames = {"before_tick", "after_tick",    "in_action",   "near_callback",
                                 "pair_filter", "contact_added", "on_contacts", "log"};
  return kNames[static_cast<std::size_t>(where)];
}

class ThrowingApps : public testing::TestWithParam<std::tuple<World, Where>> {
 protected:
  /// One step, in which the app throws.
  static void fail(App& app, Where where) {
    btDiscreteDynamicsWorld& world = app.simulation.world();
    switch (where) {
      case Where::before_tick:
        return fail_at(app, When::before_tick);
      case Where::after_tick:
        return fail_at(app, When::after_tick);
      case Where::in_action:
        return fail_at(app, When::in_action);
      case Where::near_callback: {
        auto& dispatcher = static_cast<btCollisionDispatcher&>(*world.getDispatcher());
        dispatcher.setNearCallback(
            [](btBroadphasePair&, btCollisionDispatcher&, const btDispatcherInfo&) { throw OfTheApp(); });
        EXPECT_THROW(app.simulation.step(), OfTheApp);
        dispatcher.setNearCallback(btCollisionDispatcher::defaultNearCallback);
        return;
      }
      case Where::pair_filter: {
        struct Filter : btOverlapFilterCallback {
          bool needBroadphaseCollision(btBroadphaseProxy*, btBroadphaseProxy*) const override { throw OfTheApp(); }
        } filter;
        app.bodies[2]->translate(btVector3(-5, 2, 0));
        app.bodies[2]->setVelocity(btVector3(0, -8, 0));
        world.getPairCache()->setOverlapFilterCallback(&filter);
        EXPECT_THROW(for (int i = 0; i < 60; ++i) app.simulation.step(), OfTheApp);
        world.getPairCache()->setOverlapFilterCallback(nullptr);
        return;
      }
      case Where::contact_added:
        gContactAddedCallback = [](btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                                   const btCollisionObjectWrapper*, int, int) -> bool { throw OfTheApp(); };
        EXPECT_THROW(for (int i = 0; i < 60; ++i) app.simulation.step(), OfTheApp);
        gContactAddedCallback = nullptr;
        return;
      case Where::on_contacts:
      case Where::log:
        return fail_in_settings(app, where);
    }
  }

 private:
  static void fail_at(App& app, When when) {
    const Interruption interruption(app.simulation.world(), when, [] { throw OfTheApp(); });
    EXPECT_THROW(app.simulation.step(), OfTheApp);
  }
  static void fail_in_settings(App& app, Where where) {
    bullet::WorldDetection& detection = app.simulation.detection();
    const bullet::Settings settings = detection.settings();
    bullet::Settings throwing = settings;
    if (where == Where::on_contacts) {
      throwing.on_contacts = [](const auto&) { throw OfTheApp(); };
    } else {
      throwing.log = [](LogLevel, std::string_view) { throw OfTheApp(); };
      bullet::BodyFilters filters;  // for another number of nodes than there will be, of which the log warns
      filters.nodes.resize(static_cast<std::size_t>(app.bodies[1]->m_nodes.size()));
      detection.set_filters(*app.bodies[1], filters);
      app.bodies[1]->appendNode(app.bodies[1]->m_nodes[0].m_x, btScalar(0.04));
    }
    detection.set_settings(throwing);
    EXPECT_THROW(app.simulation.step(), OfTheApp);
    detection.set_settings(settings);
  }
};
INSTANTIATE_TEST_SUITE_P(Worlds, ThrowingApps,
                         testing::Combine(kWorlds,
                                          testing::Values(Where::before_tick, Where::after_tick, Where::in_action,
                                                          Where::near_callback, Where::pair_filter,
                                                          Where::contact_added, Where::on_contacts, Where::log)),
                         [](const auto& parameter) {
                           return name_of(std::get<World>(parameter.param)) + "_" +
                                  name_of(std::get<Where>(parameter.param));
                         });

TEST_P(ThrowingApps, have_a_world_that_goes_on) {
  App app(std::get<World>(GetParam()));
  const auto algorithms = app.algorithms();
  fail(app, std::get<Where>(GetParam()));
  EXPECT_EQ(app.algorithms(), algorithms);
  EXPECT_TRUE(app.goes_on());
}

TEST_P(ThrowingApps, have_bodies_that_leave_as_they_came) {
  App app(std::get<World>(GetParam()));
  std::vector<BodyState> states = app.states();
  fail(app, std::get<Where>(GetParam()));
  if (std::get<Where>(GetParam()) == Where::log) ++states[1].leaves;
  for (std::size_t b = 0; b < states.size(); ++b) {
    const std::unique_ptr<btSoftBody> gone = app.simulation.remove(*app.bodies[b]);
    EXPECT_EQ(state_of(*gone), states[b]) << b;
  }
}

/// While it lives, the n-th allocation of Bullet's from its construction on throws, the first is 1.
class FailingAllocator {
 public:
  explicit FailingAllocator(int n) {
    left_ = n;
    btAlignedAllocSetCustom(allocate, std::free);
  }
  ~FailingAllocator() { btAlignedAllocSetCustom(nullptr, nullptr); }
  FailingAllocator(const FailingAllocator&) = delete;
  FailingAllocator& operator=(const FailingAllocator&) = delete;

  bool has_failed() const { return left_ <= 0; }

 private:
  static void* allocate(std::size_t size) {
    if (left_ > 0 && --left_ == 0) throw std::bad_alloc();
    return std::malloc(size);
  }

  static inline int left_ = 0;
};

class ThrowingAllocators : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, ThrowingAllocators, kWorlds, world_name);

TEST_P(ThrowingAllocators, have_a_world_that_goes_on) {
  App app(GetParam());
  const auto algorithms = app.algorithms();
  const std::vector<BodyState> states = app.states();
  int failures = 0;
  bool has_failed = true;
  while (has_failed) {
    const FailingAllocator failing(failures + 1);
    try {
      app.simulation.step();
    } catch (const std::bad_alloc&) {
    }
    has_failed = failing.has_failed();
    failures += has_failed;
    ASSERT_EQ(app.algorithms(), algorithms) << failures;
    const bool is_attached = GetParam() == World::attached || GetParam() == World::attached_deformable;
    if (!is_attached) {  // there some is given back when the next step begins, or the body leaves
      ASSERT_EQ(app.states(), states) << failures;
    }
  }
  std::cout << failures << " allocations failed\n";
  EXPECT_GT(failures, 5);
  EXPECT_TRUE(app.goes_on());
  for (std::size_t b = 0; b < states.size(); ++b) {
    const std::unique_ptr<btSoftBody> gone = app.simulation.remove(*app.bodies[b]);
    EXPECT_EQ(state_of(*gone), states[b]) << b;
  }
}

}  // namespace
}  // namespace softcd::test

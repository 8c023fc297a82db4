#include "viewer/session.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "softcd/pipeline/detector.hpp"

namespace softcd::demo {
namespace {

SceneOptions small() {
  SceneOptions options;
  options.size = 16;
  options.settings.backend = Backend::cpu;
  options.settings.detection = Detection::ccd;
  return options;
}

std::vector<btVector3> positions_of(const Session& session) {
  std::vector<btVector3> positions;
  for (const btSoftBody* body : session.bodies()) {
    for (int i = 0; i < body->m_nodes.size(); ++i) positions.push_back(body->m_nodes[i].m_x);
  }
  return positions;
}

std::vector<btScalar> rest_lengths_of(const Session& session) {
  std::vector<btScalar> lengths;
  for (const btSoftBody* body : session.bodies()) {
    for (int i = 0; i < body->m_links.size(); ++i) lengths.push_back(body->m_links[i].m_rl);
  }
  return lengths;
}

void run(Session& session, int steps) {
  for (int i = 0; i < steps; ++i) session.step();
}

struct Case {
  const char* name;
  const char* scene;
  int size;
};

TEST(Session, opens_another_scene) {
  Session session("two-cloths", small());
  run(session, 3);
  session.open("folding-cloth");
  EXPECT_EQ(session.scene_name(), "folding-cloth");
  EXPECT_EQ(session.scene().time(), 0);
  EXPECT_EQ(session.bodies().size(), 1U);
  EXPECT_THROW(session.open("nothing"), std::invalid_argument);
  EXPECT_EQ(session.scene_name(), "folding-cloth");
}

TEST(Session, throws_balls_that_stay_under_other_options) {
  Session session("two-cloths", small());
  const std::size_t count = session.bodies().size();
  session.throw_ball(btVector3(0, 3, 0), btScalar(0.2), btVector3(0, -5, 0));
  ASSERT_EQ(session.bodies().size(), count + 1);
  run(session, 10);
  SceneOptions options = small();
  options.settings.detection = Detection::dcd;
  const std::vector<btVector3> positions = positions_of(session);
  session.go_on_with(options);
  EXPECT_EQ(positions_of(session), positions);
  EXPECT_EQ(session.scene().all_surfaces().size(), session.scene().surfaces().size() + 1);
}

TEST(Session, gives_all_bodies_the_iterations_that_are_asked_for) {
  SceneOptions options = small();
  options.iterations = 7;
  const Session session("two-cloths", options);
  for (const btSoftBody* body : session.bodies()) EXPECT_EQ(body->m_cfg.piterations, 7);
}

TEST(Session, reads_contacts_while_it_is_asked_to) {
  Session session("two-cloths", small());
  run(session, 150);
  ASSERT_GT(session.scene().count_contacts(), 0U);
  EXPECT_TRUE(session.body_contacts().empty());
  session.set_reads_contacts(true);
  run(session, 1);
  EXPECT_FALSE(session.body_contacts().empty());
}

class SessionOf : public testing::TestWithParam<Case> {};

// Far enough that the cloths touch, and the ball turns.
TEST_P(SessionOf, goes_on_as_if_nothing_had_happened_with_the_same_options) {
  SceneOptions options = small();
  options.size = GetParam().size;
  Session switched(GetParam().scene, options);
  Session straight(GetParam().scene, options);
  run(switched, 150);
  run(straight, 150);
  switched.go_on_with(options);
  EXPECT_EQ(switched.scene().time(), straight.scene().time());
  EXPECT_EQ(positions_of(switched), positions_of(straight));
  run(switched, 1);
  run(straight, 1);
  EXPECT_GT(straight.scene().count_contacts(), 0U);
  EXPECT_EQ(switched.scene().count_contacts(), straight.scene().count_contacts());
  EXPECT_EQ(positions_of(switched), positions_of(straight));
}

INSTANTIATE_TEST_SUITE_P(Scenes, SessionOf,
                         testing::Values(Case{"ClothOnBall", "cloth-on-ball", 16}, Case{"TwoCloths", "two-cloths", 16},
                                         Case{"NBody", "n-body", 4}),
                         [](const auto& test) { return std::string(test.param.name); });

// Two runs of Bullet's deformable world differ: it draws random numbers from one sequence for all worlds.
TEST(Session, goes_on_in_the_deformable_world) {
  SceneOptions options = small();
  options.world = World::deformable;
  Session session("two-cloths", options);
  run(session, 60);
  const std::vector<btVector3> before = positions_of(session);
  const std::vector<btScalar> lengths = rest_lengths_of(session);
  session.go_on_with(options);
  EXPECT_EQ(positions_of(session), before);
  run(session, 1);
  EXPECT_EQ(rest_lengths_of(session), lengths);
  EXPECT_GT(session.scene().count_contacts(), 0U);
  const std::vector<btVector3> after = positions_of(session);
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_LT((after[i] - before[i]).length(), btScalar(0.1));
}

TEST(Session, switches_who_detects) {
  Session session("two-cloths", small());
  run(session, 60);
  const std::vector<btVector3> before = positions_of(session);
  SceneOptions options = session.options();
  options.collision = Collision::bullet;
  session.go_on_with(options);
  EXPECT_EQ(positions_of(session), before);
  EXPECT_EQ(session.scene().simulation().detection(), nullptr);
  EXPECT_EQ(session.make_grid(), nullptr);
  run(session, 1);
  EXPECT_GT(session.scene().count_contacts(), 0U) << "Bullet finds some, too";

  options.collision = Collision::off;
  session.go_on_with(options);
  run(session, 1);
  EXPECT_EQ(session.scene().count_contacts(), 0U);

  options.collision = Collision::softcd;
  session.go_on_with(options);
  ASSERT_NE(session.scene().simulation().detection(), nullptr);
  run(session, 1);
  EXPECT_GT(session.scene().count_contacts(), 0U);
}

TEST(Session, stays_as_it_is_when_it_cannot_go_on) {
  if (*cuda_problem() == '\0') GTEST_SKIP() << "there is a device";
  Session session("two-cloths", small());
  run(session, 5);
  const std::vector<btVector3> before = positions_of(session);
  SceneOptions options = session.options();
  options.settings.backend = Backend::cuda;
  EXPECT_THROW(session.go_on_with(options), BackendError);
  EXPECT_EQ(session.options().settings.backend, Backend::cpu);
  EXPECT_EQ(positions_of(session), before);
  run(session, 1);
  EXPECT_NE(positions_of(session), before);
}

TEST(Session, restarts_from_the_beginning) {
  Session session("folding-cloth", small());
  const std::vector<btVector3> first = positions_of(session);
  run(session, 10);
  EXPECT_NE(positions_of(session), first);
  session.restart();
  EXPECT_EQ(positions_of(session), first);
  EXPECT_EQ(session.scene().time(), 0);
}

TEST(Session, keeps_the_last_times) {
  Session session("two-cloths", small());
  run(session, 3);
  EXPECT_EQ(session.step_ms().values().size(), 3U);
  EXPECT_EQ(session.detection_ms().values().size(), 3U);
  EXPECT_GT(session.step_ms().last(), session.detection_ms().last());

  History history;
  for (std::size_t i = 0; i < History::kLength + 5; ++i) history.add(static_cast<float>(i));
  EXPECT_EQ(history.values().size(), History::kLength);
  EXPECT_EQ(history.values().front(), 5.0F);
  EXPECT_EQ(history.last(), static_cast<float>(History::kLength + 4));
}

}  // namespace
}  // namespace softcd::demo

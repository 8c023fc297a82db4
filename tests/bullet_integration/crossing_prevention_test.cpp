// Responses to crossings of free bodies conserve momentum and add no kinetic energy. They do not change bodies that
// already intersect.

#include "crossings/crossing_prevention.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "random.hpp"
#include "scenes/penetration.hpp"
#include "soft_body_steps.hpp"
#include "soft_body_support.hpp"

namespace softcd::test {
namespace {

using bullet::CrossingPrevention;
using bullet::CrossingsOfKind;
using bullet::ImpactZones;
using bullet::kClassicCrossings;
using bullet::kDeformableCrossings;

btVector3 random_vector(Random& random, double size) {
  const auto coordinate = [&] { return btScalar(random.uniform(-size, size)); };
  const btScalar x = coordinate();
  const btScalar y = coordinate();
  return {x, y, coordinate()};
}

struct Motion {
  btVector3 momentum{0, 0, 0};
  btScalar energy = 0;

  void add(const btVector3& velocity, btScalar mass) {
    momentum += velocity * mass;
    energy += mass * velocity.length2() / 2;
  }
};

/// Neither field of velocities has another momentum now than before, nor more energy.
void expect_no_push(const Motion& before, const Motion& after) {
  const btScalar size = btSqrt(btMax(before.energy, btScalar(1)));
  EXPECT_LT((after.momentum - before.momentum).length(), btScalar(1e-4) * size);
  EXPECT_LE(after.energy, before.energy * btScalar(1 + 1e-5) + btScalar(1e-9));
}

/// Two free sheets with different nodes, close above each other, that cross in the next step. The upper one is much
/// faster than the lower one, and each node's motion differs a little.
struct MeetingSheets {
  btSoftBodyWorldInfo world_info;
  std::unique_ptr<btSoftBody> bodies[2];

  explicit MeetingSheets(Random& random) {
    for (int b = 0; b < 2; ++b) {
      SheetOptions options;
      options.nodes_per_side = 6 + b;
      options.height = btScalar(0.05) * btScalar(b);
      bodies[b] = make_sheet(world_info, options);
      bodies[b]->setTotalMass(btScalar(1 + 2 * b));
      bodies[b]->m_cfg.collisions |= btSoftBody::fCollision::VF_DD;
      for (int n = 0; n < bodies[b]->m_nodes.size(); ++n) {
        btSoftBody::Node& node = bodies[b]->m_nodes[n];
        node.m_v = btVector3(0, btScalar(b == 0 ? 9 : -3), 0) + random_vector(random, 2);
      }
    }
  }

  template <class Velocity>
  Motion motion(Velocity velocity) const {
    Motion result;
    for (const auto& body : bodies) {
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        result.add(velocity(body->m_nodes[n]), 1 / body->m_nodes[n].m_im);
      }
    }
    return result;
  }
  Motion own_motion() const {
    return motion([](const btSoftBody::Node& node) { return node.m_v; });
  }
  Motion mean_motion() const {
    return motion([](const btSoftBody::Node& node) { return (node.m_x - node.m_q) / kStep; });
  }

  void prevent_crossings(const CrossingsOfKind& kind) const {
    bullet::Settings settings = test_settings(Detection::ccd);
    settings.edge_contacts = bullet::EdgeContacts::respond;
    bullet::WorldMirror mirror(kind.ends, settings);
    CrossingPrevention prevention(kind, mirror, settings);
    btSoftBody* const pointers[] = {bodies[0].get(), bodies[1].get()};
    EXPECT_TRUE(prevention.run(
        {pointers, 2}, [](btSoftBody&, btSoftBody&) { return true; }, kStep));
  }
};

constexpr int kTries = 5;

// The state after contacts of later bodies: Bullet moves nodes whose velocities it has already set.
TEST(AnswersToCrossings, keep_what_a_classic_body_has_that_was_moved_but_not_pushed) {
  for (int seed = 0; seed < kTries; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const MeetingSheets sheets(random);
    for (const auto& body : sheets.bodies) {
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        btSoftBody::Node& node = body->m_nodes[n];
        node.m_q = node.m_x;
        node.m_x += node.m_v * kStep;
        node.m_v = seed == 0 ? btVector3(0, 0, 0) : random_vector(random, 1);
      }
    }
    const Motion own = sheets.own_motion();
    const Motion mean = sheets.mean_motion();
    sheets.prevent_crossings(kClassicCrossings);
    expect_no_push(own, sheets.own_motion());
    expect_no_push(mean, sheets.mean_motion());
    EXPECT_LT(sheets.mean_motion().energy, mean.energy / 2) << "they have met";
  }
}

TEST(AnswersToCrossings, keep_what_deformable_bodies_have) {
  for (int seed = 0; seed < kTries; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const MeetingSheets sheets(random);
    const Motion own = sheets.own_motion();
    sheets.prevent_crossings(kDeformableCrossings);
    expect_no_push(own, sheets.own_motion());
    EXPECT_LT(sheets.own_motion().energy, own.energy / 2) << "they have met";
  }
}

// Split velocities move nodes out of rigid bodies in this step and are gone after it.
TEST(AnswersToCrossings, make_no_velocity_out_of_split_velocities) {
  Random random(1);
  const MeetingSheets sheets(random);
  const auto split = [](const btSoftBody::Node& node) { return node.m_splitv; };
  bullet::Impact impact{};
  for (int i = 0; i < 4; ++i) {
    impact.nodes[i] = &sheets.bodies[i / 2]->m_nodes[i];
    impact.nodes[i]->m_splitv = random_vector(random, 20);
  }
  const Motion own = sheets.own_motion();
  const Motion splits = sheets.motion(split);
  ImpactZones zones(kDeformableCrossings.ends.start, kStep);
  EXPECT_TRUE(zones.join({impact}));
  zones.move_as_one();
  expect_no_push(own, sheets.own_motion());
  expect_no_push(splits, sheets.motion(split));
  for (const btSoftBody::Node* node : impact.nodes) {
    const btVector3 distance = node->m_x - impact.nodes[0]->m_x;
    EXPECT_NEAR(distance.dot(node->m_v - impact.nodes[0]->m_v), 0, 1e-4);
    EXPECT_NEAR(distance.dot(node->m_splitv - impact.nodes[0]->m_splitv), 0, 1e-4);
  }
}

// An impulse along a normal that is nearly at right angles to the node's only free direction would move it a hundred
// times as fast as what pushes it.
TEST(AnswersToCrossings, do_not_throw_a_node_that_can_hardly_give_way) {
  btSoftBodyWorldInfo world_info;
  const auto body = make_sheet(world_info, {});
  bullet::NodeConstraint constraint;
  constraint.add_direction({1, 0, 0});
  constraint.add_direction({0, 1, 0});
  bullet::Impact impact{};
  for (int i = 0; i < 4; ++i) {
    impact.nodes[i] = &body->m_nodes[i];
    impact.weights[i] = i == 0 ? btScalar(1) : btScalar(-1) / 3;
    if (i > 0) body->setMass(i, 0);
  }
  impact.constraints[0] = &constraint;
  impact.normal = btVector3(1, 0, btScalar(0.01)).normalized();
  constexpr btScalar kSpeed = 10;
  for (int i = 1; i < 4; ++i) impact.nodes[i]->m_v = kSpeed * impact.normal;
  bullet::apply_inelastic_impulses({impact});
  const btVector3& velocity = impact.nodes[0]->m_v;
  EXPECT_GT(velocity.z(), 0) << "it gives way";
  EXPECT_LT(velocity.length(), 2 * kSpeed);
}

/// Sheets in a cube that fly wildly and cross each other in the next step, within a cage of others that do not move.
class WildSheets {
 public:
  explicit WildSheets(Random& random) {
    for (int i = 0; i < kSide * kSide * kSide; ++i) add(i, random);
  }

  Span<btSoftBody* const> bodies() const { return {pointers_.data(), pointers_.size()}; }

  bullet::CrossingAnswers prevent_crossings(const CrossingsOfKind& kind) {
    bullet::Settings settings = test_settings(Detection::ccd);
    settings.edge_contacts = bullet::EdgeContacts::respond;
    settings.self_collision = bullet::SelfCollision::all;
    bullet::WorldMirror mirror(kind.ends, settings);
    CrossingPrevention prevention(kind, mirror, settings);
    prevention.run(
        bodies(), [](btSoftBody&, btSoftBody&) { return true; }, kStep);
    return prevention.answers();
  }

  /// Edges that intersect triangles at the step's end, which becomes where the nodes are.
  std::size_t count_intersections(const CrossingsOfKind& kind) {
    for (btSoftBody* body : pointers_) {
      for (int n = 0; n < body->m_nodes.size(); ++n) body->m_nodes[n].m_x = body->m_nodes[n].*kind.ends.end;
    }
    return demo::find_intersections({pointers_.begin(), pointers_.end()}).edge_count;
  }

  /// Starts another step.
  void set_out(const CrossingsOfKind& kind, Random& random, double speed) {
    for (btSoftBody* body : pointers_) {
      body->m_cfg.collisions = kind.ends.vertex_face_flag;
      const bool is_fixed = body->m_nodes[0].m_im == 0;
      const btVector3 velocity = random_vector(random, speed);
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        btSoftBody::Node& node = body->m_nodes[n];
        node.m_q = node.m_x;
        node.m_splitv.setZero();
        node.m_v = is_fixed ? btVector3(0, 0, 0) : velocity + random_vector(random, speed / 4);
        node.*kind.ends.end += node.m_v * kStep;
      }
    }
  }

 private:
  static constexpr int kSide = 3;

  void add(int place, Random& random) {
    SheetOptions options;
    options.nodes_per_side = 5;
    options.side = btScalar(0.5);
    options.fixed = place % 5 == 0;
    auto sheet = make_sheet(world_info_, options);
    sheet->rotate(btQuaternion(random_vector(random, 1).normalized(), btScalar(random.uniform(0, 3))));
    const int row = place / kSide % kSide;
    const int layer = place / kSide / kSide;
    const btVector3 center(btScalar(place % kSide), btScalar(row), btScalar(layer));
    sheet->translate(center * btScalar(0.75));
    pointers_.push_back(sheet.get());
    sheets_.push_back(std::move(sheet));
  }

  btSoftBodyWorldInfo world_info_;
  std::vector<std::unique_ptr<btSoftBody>> sheets_;
  std::vector<btSoftBody*> pointers_;
};

// However wildly: where the step began nothing was through anything else.
TEST(AnswersToCrossings, leave_no_intersection) {
  for (const CrossingsOfKind* kind : {&kClassicCrossings, &kDeformableCrossings}) {
    for (const double speed : {40, 4000}) {
      Random random(static_cast<std::uint64_t>(speed));
      WildSheets sheets(random);
      for (int step = 0; step < 3; ++step) {
        sheets.set_out(*kind, random, speed);
        const bullet::CrossingAnswers answers = sheets.prevent_crossings(*kind);
        EXPECT_GT(answers.impacts, 100U);
        EXPECT_EQ(answers.unavoidable, 0U);
        EXPECT_EQ(sheets.count_intersections(*kind), 0U);
      }
    }
  }
}

std::size_t count_intersections_after(CrossingsOfKind kind, const bullet::AnswerRounds& rounds) {
  kind.rounds = rounds;
  Random random(1);
  WildSheets sheets(random);
  sheets.set_out(kind, random, 40);
  sheets.prevent_crossings(kind);
  return sheets.count_intersections(kind);
}

// Without them something is through something else, and more the earlier they end.
TEST(AnswersToCrossings, take_impulses_zones_and_nodes_that_are_held) {
  for (const CrossingsOfKind* kind : {&kClassicCrossings, &kDeformableCrossings}) {
    bullet::AnswerRounds rounds;
    rounds.last = 0;
    const std::size_t without = count_intersections_after(*kind, rounds);
    rounds.last = rounds.impulses;
    const std::size_t after_impulses = count_intersections_after(*kind, rounds);
    rounds.zones = rounds.last = rounds.impulses + 1;
    const std::size_t after_zones = count_intersections_after(*kind, rounds);
    EXPECT_LT(after_impulses, without);
    EXPECT_LT(after_zones, after_impulses);
    EXPECT_GT(after_zones, 0U);
    rounds.last = bullet::AnswerRounds().last;
    EXPECT_EQ(count_intersections_after(*kind, rounds), 0U) << "the rest is held";
    EXPECT_EQ(count_intersections_after(*kind, {}), 0U);
  }
}

/// Small sheets, 10 cm above each other, the lowest of which is heavy and moves upward.
class Row {
 public:
  Row(const CrossingsOfKind& kind, int count, btScalar way) {
    for (int i = 0; i < count; ++i) {
      SheetOptions options;
      options.nodes_per_side = 2;
      options.height = btScalar(0.1) * btScalar(i);
      auto sheet = make_sheet(world_info_, options);
      sheet->setTotalMass(i == 0 ? btScalar(1e6) : btScalar(1));
      sheet->m_cfg.collisions = kind.ends.vertex_face_flag;
      for (int n = 0; n < sheet->m_nodes.size(); ++n) {
        btSoftBody::Node& node = sheet->m_nodes[n];
        node.m_v = btVector3(0, i == 0 ? way / kStep : btScalar(0), 0);
        node.m_q = node.m_x;
        node.*kind.ends.end += node.m_v * kStep;
      }
      pointers_.push_back(sheet.get());
      sheets_.push_back(std::move(sheet));
    }
  }

  /// The app moves it, or holds it.
  void take_mass(std::size_t sheet) {
    for (int n = 0; n < 4; ++n) pointers_[sheet]->setMass(n, 0);
  }

  Span<btSoftBody* const> bodies() const { return {pointers_.data(), pointers_.size()}; }
  bool is_in_order(const CrossingsOfKind& kind) const {
    for (std::size_t i = 1; i < pointers_.size(); ++i) {
      for (int n = 0; n < 4; ++n) {
        if (!((pointers_[i]->m_nodes[n].*kind.ends.end).y() > (pointers_[i - 1]->m_nodes[n].*kind.ends.end).y()))
          return false;
      }
    }
    return true;
  }
  btScalar momentum() const {
    btScalar sum = 0;
    for (const btSoftBody* body : pointers_) {
      for (int n = 0; n < 4; ++n) sum += body->m_nodes[n].m_v.y() / body->m_nodes[n].m_im;
    }
    return sum;
  }

 private:
  btSoftBodyWorldInfo world_info_;
  std::vector<std::unique_ptr<btSoftBody>> sheets_;
  std::vector<btSoftBody*> pointers_;
};

bullet::CrossingAnswers prevent_crossings(const CrossingsOfKind& kind, const Row& row,
                                          const bullet::Settings& settings) {
  bullet::WorldMirror mirror(kind.ends, settings);
  CrossingPrevention prevention(kind, mirror, settings);
  prevention.run(
      row.bodies(), [](btSoftBody&, btSoftBody&) { return true; }, kStep);
  return prevention.answers();
}

// A sheet that the lowest one pushes moves as far as it does, two and a half of the gaps, and meets the next sheet. So
// every response leads to further impacts.
TEST(AnswersToCrossings, end_with_nodes_that_stay_where_they_were) {
  for (const CrossingsOfKind* kind : {&kClassicCrossings, &kDeformableCrossings}) {
    const Row row(*kind, 60, btScalar(0.25));
    const btScalar momentum = row.momentum();
    const bullet::CrossingAnswers answers = prevent_crossings(*kind, row, test_settings(Detection::ccd));
    EXPECT_GT(answers.rounds, 25U);
    EXPECT_GT(answers.held_nodes, 0U);
    EXPECT_EQ(answers.unavoidable, 0U);
    EXPECT_TRUE(row.is_in_order(*kind));
    EXPECT_NEAR(row.momentum() / momentum, 1, 1e-4) << "held for one step only";
  }
}

TEST(AnswersToCrossings, name_what_nodes_that_the_app_moves_pass_through) {
  for (const CrossingsOfKind* kind : {&kClassicCrossings, &kDeformableCrossings}) {
    Row press(*kind, 3, btScalar(0.25));
    press.take_mass(0);
    press.take_mass(2);
    std::vector<std::string> warnings;
    bullet::Settings settings = test_settings(Detection::ccd);
    settings.log = [&warnings](LogLevel /*level*/, std::string_view text) { warnings.emplace_back(text); };
    const bullet::CrossingAnswers answers = prevent_crossings(*kind, press, settings);
    EXPECT_GT(answers.unavoidable, 0U);
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_NE(warnings[0].find("in " + std::to_string(answers.unavoidable) + " impacts"), std::string::npos);
  }
}

// They would hang in the air for ever.
TEST(AnswersToCrossings, do_not_hold_what_touches_from_the_start) {
  for (const CrossingsOfKind* kind : {&kClassicCrossings, &kDeformableCrossings}) {
    btSoftBodyWorldInfo world_info;
    const auto first = make_sheet(world_info, {});
    const auto second = make_sheet(world_info, {});
    btSoftBody* const bodies[] = {first.get(), second.get()};
    for (btSoftBody* body : bodies) {
      body->m_cfg.collisions = kind->ends.vertex_face_flag;
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        btSoftBody::Node& node = body->m_nodes[n];
        node.m_v = btVector3(0, -1, 0);
        node.m_q = node.m_x;
        node.*kind->ends.end += node.m_v * kStep;
      }
    }
    std::vector<std::string> warnings;
    bullet::Settings settings = test_settings(Detection::ccd);
    settings.log = [&warnings](LogLevel /*level*/, std::string_view text) { warnings.emplace_back(text); };
    bullet::WorldMirror mirror(kind->ends, settings);
    CrossingPrevention prevention(*kind, mirror, settings);
    EXPECT_FALSE(prevention.run(
        {bodies, 2}, [](btSoftBody&, btSoftBody&) { return true; }, kStep));
    EXPECT_GT(prevention.query().statistics().vt_contacts, 0U) << "they are found, and may stay";
    EXPECT_EQ(prevention.answers().held_nodes, 0U);
    EXPECT_EQ(prevention.answers().unavoidable, 0U);
    EXPECT_TRUE(warnings.empty());
    for (const btSoftBody* body : bodies) {
      EXPECT_NEAR((body->m_nodes[0].*kind->ends.end).y(), -kStep, 1e-5) << "they fall together";
    }
  }
}

/// A triangle of nodes that go where the app sends them, but for one that may be free.
std::unique_ptr<btSoftBody> make_free_triangle(btSoftBodyWorldInfo& world_info, const CrossingsOfKind& kind,
                                               const std::array<btVector3, 3>& places,
                                               const std::array<btVector3, 3>& ways) {
  auto body = std::make_unique<btSoftBody>(&world_info, 3, places.data(), nullptr);
  body->appendFace(0, 1, 2);
  body->m_cfg.collisions = kind.ends.vertex_face_flag;
  for (int n = 0; n < 3; ++n) {
    btSoftBody::Node& node = body->m_nodes[n];
    body->setMass(n, 0);
    node.m_v = ways[static_cast<std::size_t>(n)] / kStep;
    node.m_splitv.setZero();
    node.m_q = node.m_x;
    node.*kind.ends.end += node.m_v * kStep;
  }
  return body;
}

// A dancer, her skirt's waist that turns with her, and a node of the skirt. An edge at that node lies on an edge of
// hers, up to the rounding of their positions. Recorded; nodes that move as one with her meet her by rounding.
TEST(AnswersToCrossings, keep_apart_what_all_but_touches_when_the_app_moves_it) {
  const btVector3 way_a(btScalar(-0.00257956), 0, btScalar(-0.00108461));
  const btVector3 way_b(btScalar(-0.00216515), btScalar(1.19209e-07), btScalar(-0.000929065));
  const btVector3 way_c(btScalar(-0.00187558), btScalar(1.19209e-07), btScalar(-0.001725));
  const btVector3 a(btScalar(0.0624395832), btScalar(1.01499999), btScalar(0.135462478));
  const btVector3 b(btScalar(0.0710173696), btScalar(1.07999992), btScalar(0.11198011));
  const btVector3 c(btScalar(0.02591943), btScalar(1.07999992), btScalar(0.0960227251));
  const btVector3 free_node(btScalar(0.146585181), btScalar(0.974621773), btScalar(0.181709215));
  for (const CrossingsOfKind* kind : {&kClassicCrossings, &kDeformableCrossings}) {
    btSoftBodyWorldInfo world_info;
    const auto dancer =
        make_free_triangle(world_info, *kind, {a, b, btVector3(0, btScalar(1.05), 0)}, {way_a, way_b, way_b});
    const auto skirt =
        make_free_triangle(world_info, *kind, {c, free_node, btVector3(btScalar(0.09), btScalar(1.05), btScalar(0.3))},
                           {way_c, btVector3(0, 0, 0), way_c});
    skirt->setMass(1, btScalar(0.01));
    btSoftBody* const bodies[] = {dancer.get(), skirt.get()};
    bullet::Settings settings = test_settings(Detection::ccd);
    settings.edge_contacts = bullet::EdgeContacts::respond;
    bullet::WorldMirror mirror(kind->ends, settings);
    CrossingPrevention prevention(*kind, mirror, settings);
    EXPECT_TRUE(prevention.run(
        {bodies, 2}, [](btSoftBody&, btSoftBody&) { return true; }, kStep));
    EXPECT_EQ(prevention.answers().unavoidable, 0U);
    for (btSoftBody* body : bodies) {
      for (int n = 0; n < 3; ++n) body->m_nodes[n].m_x = body->m_nodes[n].*kind->ends.end;
    }
    EXPECT_EQ(demo::find_intersections({dancer.get(), skirt.get()}).edge_count, 0U);
    EXPECT_LT((skirt->m_nodes[1].m_x - free_node).length(), btScalar(0.01)) << "it goes with them";
  }
}

/// Moves a sheet whose middle node alone is below another sheet up until it is free. Returns whether it was stopped.
bool is_held_back(const CrossingsOfKind& kind, bullet::EdgeContacts edge_contacts) {
  btSoftBodyWorldInfo world_info;
  SheetOptions options;
  options.side = 4;
  options.nodes_per_side = 2;
  const auto ground = make_sheet(world_info, options);
  options.side = 1;
  options.nodes_per_side = 3;
  options.height = btScalar(0.05);
  const auto sheet = make_sheet(world_info, options);
  sheet->translate(btVector3(btScalar(0.3), 0, btScalar(0.1)));
  sheet->m_nodes[4].m_x -= btVector3(0, btScalar(0.1), 0);
  btSoftBody* const bodies[] = {ground.get(), sheet.get()};
  for (btSoftBody* body : bodies) {
    body->m_cfg.collisions |= btSoftBody::fCollision::VF_DD;
    const btVector3 motion(0, body == sheet.get() ? btScalar(0.2) : btScalar(0), 0);
    for (int n = 0; n < body->m_nodes.size(); ++n) {
      btSoftBody::Node& node = body->m_nodes[n];
      node.m_v = motion / kStep;
      node.m_q = node.m_x;
      node.*kind.ends.end += motion;
    }
  }
  bullet::Settings settings = test_settings(Detection::ccd);
  settings.edge_contacts = edge_contacts;
  bullet::WorldMirror mirror(kind.ends, settings);
  return CrossingPrevention(kind, mirror, settings)
      .run(
          {bodies, 2}, [](btSoftBody&, btSoftBody&) { return true; }, kStep);
}

TEST(AnswersToCrossings, let_go_what_is_through_something_where_edges_are_answered) {
  for (const CrossingsOfKind* kind : {&kClassicCrossings, &kDeformableCrossings}) {
    EXPECT_FALSE(is_held_back(*kind, bullet::EdgeContacts::respond));
    EXPECT_TRUE(is_held_back(*kind, bullet::EdgeContacts::off)) << "nodes never pass through faces";
  }
}

}  // namespace
}  // namespace softcd::test

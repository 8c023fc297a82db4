#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "random.hpp"
#include "scene_parts.hpp"

// Several queries on one scene find the same contacts as a pipeline of their own.
namespace softcd::test {
namespace {

using testing::HasSubstr;

SceneBody soup_body(std::uint64_t seed, std::uint32_t triangle_count = 120) {
  SoupOptions options;
  options.triangle_count = triangle_count;
  options.half_extent = 1.5;
  options.largest = 0.5;
  options.joined_share = 0.4;
  options.seed = seed;
  const Mesh mesh = triangle_soup(options);
  return moving(mesh, scattered(mesh, 0.4, seed + 100), everything(0.02F));
}

/// A scene's bodies in a softcd::Scene.
struct FilledScene {
  explicit FilledScene(Scene its_bodies) : bodies(std::move(its_bodies)) {
    for (const SceneBody& body : bodies) {
      ids.push_back(scene.add_body(desc_of(body)));
      scene.set_positions(ids.back(), body.x_t0, body.x_t1);
    }
  }

  Scene bodies;
  softcd::Scene scene{scene_options()};
  std::vector<BodyId> ids;
};

Scene three_soups() {
  return {soup_body(1), soup_body(2), soup_body(3)};
}

PipelineOptions alone(const QueryOptions& query) {
  PipelineOptions options;
  static_cast<QueryOptions&>(options) = query;
  options.backend = backend_under_test();
  return options;
}

TEST(Queries, of_one_scene_find_what_each_would_alone) {
  FilledScene filled(three_soups());
  std::vector<QueryOptions> all(7);
  all[1].detection = Detection::ccd;
  all[2].motion_margin = 2.0F;
  all[3].contact_rule = ContactRule::slab;
  all[4].detection = Detection::ccd;
  all[4].accuracy = Accuracy::conservative;
  all[5].features = {true, false};
  all[6].motion_margin = 2.0F;
  all[6].contact_rule = ContactRule::ahead;
  std::vector<Query> queries;
  for (const QueryOptions& options : all) queries.emplace_back(filled.scene, options);
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      SCOPED_TRACE(testing::Message() << "query " << i << " in round " << round);
      EXPECT_TRUE(identical(detect_once(filled.bodies, alone(all[i])), queries[i].detect()));
      EXPECT_EQ(queries[i].statistics().backend, backend_under_test());
      EXPECT_EQ(queries[i].statistics().bodies, 3U);
    }
    filled.bodies[1].x_t1 = translated(filled.bodies[1].x_t1, {0.01, 0.0, 0.02});
    filled.scene.set_positions(filled.ids[1], filled.bodies[1].x_t0, filled.bodies[1].x_t1);
  }
}

TEST(Queries, look_at_the_start_of_a_step) {
  FilledScene filled(three_soups());
  QueryOptions options;
  options.step_end = StepEnd::t0;
  Query at_t0(filled.scene, options);
  Query at_t1(filled.scene, {});
  Scene start = filled.bodies;
  for (SceneBody& body : start) body.x_t1 = body.x_t0;
  const std::vector<Contact> expected = detect_once(start, alone({}));
  ASSERT_FALSE(identical(expected, detect_once(filled.bodies, alone({}))));
  EXPECT_TRUE(identical(expected, at_t0.detect()));
  EXPECT_TRUE(identical(detect_once(filled.bodies, alone({})), at_t1.detect()));
  // The positions of a body that does not move are those of t1 at t0, too.
  filled.scene.set_positions(filled.ids[0], filled.bodies[0].x_t1);
  start[0].x_t0 = start[0].x_t1 = filled.bodies[0].x_t1;
  EXPECT_TRUE(identical(detect_once(start, alone({})), at_t0.detect()));
}

TEST(Queries, do_without_margins_and_kinds_of_features) {
  FilledScene filled(three_soups());
  QueryOptions options = looking_for(Detection::ccd);
  options.margins = false;
  options.features = {true, false};
  Query query(filled.scene, options);
  Scene bare = filled.bodies;
  for (SceneBody& body : bare) {
    body.settings.margin = 0.0F;
    body.settings.features = {true, false};
  }
  EXPECT_TRUE(identical(detect_once(bare, alone(looking_for(Detection::ccd))), query.detect()));
}

TEST(Queries, ask_their_filters_about_bodies_and_themselves) {
  FilledScene filled(three_soups());
  Query query(filled.scene, {});
  std::vector<std::pair<std::uint32_t, std::uint32_t>> asked;
  query.set_pair_filter([&](BodyId a, BodyId b) {
    asked.emplace_back(a.value, b.value);
    return a != b;
  });
  Scene others = filled.bodies;
  for (SceneBody& body : others) body.settings.self_collision = false;
  EXPECT_TRUE(identical(detect_once(others, alone({})), query.detect()));
  EXPECT_EQ(asked.size(), 6U);
}

TEST(Queries, compare_only_what_was_changed_since_they_last_looked) {
  FilledScene filled(three_soups());
  Query query(filled.scene, looking_for(Detection::ccd));
  const std::vector<Contact> all = copy_of(query.detect(Pairs::changed));
  EXPECT_TRUE(identical(all, query.detect())) << "everything is new to a new query";
  EXPECT_TRUE(query.detect(Pairs::changed).empty());
  filled.scene.set_positions(filled.ids[2], filled.bodies[2].x_t0, filled.bodies[2].x_t1);
  std::vector<Contact> expected;
  std::copy_if(all.begin(), all.end(), std::back_inserter(expected), [&](const Contact& contact) {
    return contact.body_a == filled.ids[2] || contact.body_b == filled.ids[2];
  });
  ASSERT_FALSE(expected.empty());
  ASSERT_LT(expected.size(), all.size());
  EXPECT_TRUE(identical(expected, query.detect(Pairs::changed)));
  EXPECT_TRUE(identical(all, query.detect()));
}

TEST(Queries, count_pairs_that_are_not_ignored_any_more_as_changed) {
  FilledScene filled(three_soups());
  Query query(filled.scene, looking_for(Detection::ccd));
  const std::vector<Contact> all = copy_of(query.detect());
  const BodyPair pair = {filled.ids[0], filled.ids[2]};
  const auto is_of_pair = [&](const Contact& contact) {
    return contact.body_a != contact.body_b && contact.body_a != filled.ids[1] && contact.body_b != filled.ids[1];
  };
  ASSERT_TRUE(std::any_of(all.begin(), all.end(), is_of_pair));
  filled.scene.set_ignored_pairs({&pair, 1});
  EXPECT_LT(query.detect().size(), all.size());
  filled.scene.set_ignored_pairs({});
  const std::vector<Contact> changed = copy_of(query.detect(Pairs::changed));
  EXPECT_EQ(std::count_if(changed.begin(), changed.end(), is_of_pair),
            std::count_if(all.begin(), all.end(), is_of_pair));
}

TEST(HeldContacts, outlive_further_detections_their_query_and_its_scene) {
  auto filled = std::make_unique<FilledScene>(three_soups());
  auto query = std::make_unique<Query>(filled->scene);
  const Span<const Contact> found = query->detect();
  const std::vector<Contact> expected = copy_of(found);
  ASSERT_FALSE(expected.empty());
  const std::shared_ptr<const void> held = query->hold_contacts();
  for (int step = 0; step < 3; ++step) {
    filled->scene.set_positions(filled->ids[0], filled->bodies[0].x_t0);
    filled->bodies[0].x_t1 = filled->bodies[0].x_t0;
    EXPECT_TRUE(identical(detect_once(filled->bodies, alone({})), query->detect()));
    EXPECT_TRUE(identical(expected, found));
  }
  query->set_options(looking_for(Detection::ccd));
  query->detect();
  SceneOptions elsewhere = scene_options();
  elsewhere.backend = elsewhere.backend == Backend::cpu ? Backend::automatic : Backend::cpu;
  filled->scene.set_options(elsewhere);
  query->detect();
  EXPECT_TRUE(identical(expected, found));
  query.reset();
  filled.reset();
  EXPECT_TRUE(identical(expected, found));
}

TEST(HeldContacts, give_their_memory_to_a_later_detection) {
  FilledScene filled(three_soups());
  Query query(filled.scene);
  std::set<const Contact*> places;
  std::shared_ptr<const void> held;
  for (int step = 0; step < 6; ++step) {
    places.insert(query.detect().data());
    held = query.hold_contacts();
  }
  EXPECT_EQ(places.size(), 2U);
}

TEST(HeldContacts, have_to_be_there) {
  FilledScene filled(three_soups());
  Query query(filled.scene);
  const auto error = [&] { return error_of([&] { query.hold_contacts(); }); };
  EXPECT_THAT(error(), HasSubstr("no contacts to hold"));
  query.detect();
  Ticket ticket = query.start();
  EXPECT_THAT(error(), HasSubstr("no contacts to hold"));
  ticket.wait();
  EXPECT_EQ(error(), "no exception");
  query.set_options(looking_for(Detection::ccd));
  EXPECT_THAT(error(), HasSubstr("no contacts to hold"));
}

TEST(Tickets, of_a_streaming_loop_have_the_contacts_of_a_plain_one) {
  constexpr int kSteps = 1000;
  const Mesh sheet = grid_cloth(6, 6, 0.25);
  const SceneBody upper =
      moving(moved(sheet, {0.1, 0.1, 0.08}), translated(sheet.positions, {0.1, 0.1, 0.04}), everything(0.05F));
  FilledScene plain({still(sheet, everything(0.05F)), upper});
  FilledScene streaming({still(sheet, everything(0.05F)), upper});
  Query plain_query(plain.scene, looking_for(Detection::ccd));
  Query streaming_query(streaming.scene, looking_for(Detection::ccd));
  const auto end_of_step = [&](int step) {
    return translated(upper.x_t1, {0.0, 0.001 * (step % 97), 0.0005 * (step % 113) - 0.03});
  };
  Positions3 from = end_of_step(0);
  Positions3 to = end_of_step(1);
  std::size_t contacts = 0;
  streaming.scene.set_positions(streaming.ids[1], from, to);
  Ticket ticket = streaming_query.start();
  for (int step = 1; step <= kSteps; ++step) {
    plain.scene.set_positions(plain.ids[1], from, to);
    const Span<const Contact> expected = plain_query.detect();
    from = std::exchange(to, end_of_step(step + 1));
    streaming.scene.set_positions(streaming.ids[1], from, to);
    ASSERT_TRUE(identical(expected, ticket.wait())) << "step " << step;
    contacts += expected.size();
    ticket = streaming_query.start();
  }
  EXPECT_GT(contacts, 10'000U);
}

TEST(Tickets, are_waited_for_once) {
  FilledScene filled(three_soups());
  Query query(filled.scene, {});
  Ticket ticket = query.start();
  const std::vector<Contact> found = copy_of(ticket.wait());
  EXPECT_THAT(error_of([&] { ticket.wait(); }), HasSubstr("waited for twice"));
  EXPECT_TRUE(identical(found, query.detect()));
}

TEST(Tickets, give_way_to_later_ones_of_their_query) {
  FilledScene filled(three_soups());
  Query query(filled.scene, {});
  Ticket first = query.start();
  Ticket second = query.start();
  EXPECT_THAT(error_of([&] { first.wait(); }), HasSubstr("another detection"));
  EXPECT_TRUE(identical(detect_once(filled.bodies, alone({})), second.wait()));
}

TEST(Tickets, of_several_queries_are_waited_for_in_any_order) {
  FilledScene filled(three_soups());
  Query discrete(filled.scene, looking_for(Detection::dcd));
  Query continuous(filled.scene, looking_for(Detection::ccd));
  Ticket first = discrete.start();
  Ticket second = continuous.start();
  const Span<const Contact> moving_contacts = second.wait();
  EXPECT_TRUE(identical(detect_once(filled.bodies, alone(looking_for(Detection::dcd))), first.wait()));
  EXPECT_TRUE(identical(detect_once(filled.bodies, alone(looking_for(Detection::ccd))), moving_contacts));
}

TEST(Tickets, say_what_is_gone) {
  auto filled = std::make_unique<FilledScene>(three_soups());
  auto query = std::make_unique<Query>(filled->scene, QueryOptions());
  Ticket of_gone_query = query->start();
  query = std::make_unique<Query>(filled->scene, QueryOptions());
  EXPECT_THAT(error_of([&] { of_gone_query.wait(); }), HasSubstr("Query is gone"));
  const std::vector<Contact> found = copy_of(query->detect());
  const std::uint64_t count = query->statistics().vt_contacts;
  Ticket of_gone_scene = query->start();
  filled.reset();
  EXPECT_THAT(error_of([&] { of_gone_scene.wait(); }), HasSubstr("Scene is gone"));
  EXPECT_THAT(error_of([&] { query->detect(); }), HasSubstr("Scene of this Query is gone"));
  EXPECT_THAT(error_of([&] { query->set_options({}); }), HasSubstr("Scene of this Query is gone"));
  EXPECT_EQ(query->statistics().vt_contacts, count);
  EXPECT_FALSE(query->explain().empty());
  Ticket taken = std::move(of_gone_scene);
  // NOLINTNEXTLINE(bugprone-use-after-move): this is what it says then.
  EXPECT_THAT(error_of([&] { of_gone_scene.wait(); }), HasSubstr("moved"));
}

TEST(Tickets, of_detections_that_new_options_ended_say_so) {
  FilledScene filled(three_soups());
  Query query(filled.scene, {});
  Ticket ticket = query.start();
  query.set_options(looking_for(Detection::ccd));
  EXPECT_THAT(error_of([&] { ticket.wait(); }), HasSubstr("options"));
  ticket = query.start();
  SceneOptions options = scene_options();
  options.max_threads = 1;
  filled.scene.set_options(options);
  EXPECT_THAT(error_of([&] { ticket.wait(); }), HasSubstr("options"));
  EXPECT_TRUE(identical(detect_once(filled.bodies, alone(looking_for(Detection::ccd))), query.detect()));
}

// Also if the detection had no work, or another query's detection had to wait for it.
TEST(Tickets, of_detections_that_do_not_run_any_more_end_as_others_do) {
  auto empty = std::make_unique<softcd::Scene>(scene_options());
  auto filled = std::make_unique<FilledScene>(three_soups());
  Query without_work(*empty, {});
  Query first(filled->scene, {});
  Query second(filled->scene, {});
  const auto start_all = [&] {
    std::vector<Ticket> tickets;
    tickets.push_back(without_work.start());
    tickets.push_back(first.start());
    tickets.push_back(second.start());
    return tickets;
  };
  std::vector<Ticket> tickets = start_all();
  SceneOptions options = scene_options();
  options.max_threads = 1;
  empty->set_options(options);
  filled->scene.set_options(options);
  for (Ticket& ticket : tickets) EXPECT_THAT(error_of([&] { ticket.wait(); }), HasSubstr("options"));
  tickets = start_all();
  empty.reset();
  filled.reset();
  for (Ticket& ticket : tickets) EXPECT_THAT(error_of([&] { ticket.wait(); }), HasSubstr("Scene is gone"));
}

TEST(Scenes, know_their_bodies) {
  FilledScene filled(three_soups());
  softcd::Scene& scene = filled.scene;
  EXPECT_TRUE(scene.has_body(filled.ids[1]));
  scene.remove_body(filled.ids[1]);
  EXPECT_FALSE(scene.has_body(filled.ids[1]));
  EXPECT_FALSE(scene.has_body(BodyId{77}));
  const BodyId gone = filled.ids[1];
  for (const auto& call : std::vector<std::function<void()>>{
           [&] { scene.remove_body(gone); }, [&] { scene.set_settings(gone, {}); },
           [&] { scene.update_body(gone, {}); }, [&] { scene.set_positions(gone, filled.bodies[1].x_t1); }}) {
    EXPECT_THAT(error_of(call), HasSubstr("body 1 is not in the scene"));
  }
}

// The process never gets more threads than it may have.
TEST(Scenes, take_any_number_of_threads) {
  const std::vector<Contact> expected = detect_once(three_soups(), test_options(Detection::dcd));
  PipelineOptions options = test_options(Detection::dcd);
  for (const std::uint32_t threads : {0x10000U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFFU}) {
    options.max_threads = threads;
    LoadedScene loaded = load(three_soups(), options);
    EXPECT_TRUE(identical(expected, loaded.pipeline.detect())) << threads;
    options.max_threads = threads - 1;
    loaded.pipeline.set_options(options);
    EXPECT_TRUE(identical(expected, loaded.pipeline.detect())) << threads - 1;
  }
}

TEST(Scenes, that_were_moved_from_say_so) {
  FilledScene filled(three_soups());
  softcd::Scene taken = std::move(filled.scene);
  EXPECT_THAT(error_of([&] { filled.scene.backend(); }), HasSubstr("moved"));
  EXPECT_THAT(error_of([&] { const Query query(filled.scene, {}); }), HasSubstr("moved"));
  Query query(taken, {});
  Query other = std::move(query);
  // NOLINTNEXTLINE(bugprone-use-after-move): this is what it says then.
  EXPECT_THAT(error_of([&] { query.detect(); }), HasSubstr("moved"));
  EXPECT_TRUE(identical(detect_once(filled.bodies, alone({})), other.detect()));
}

TEST(Scenes, refuse_options_out_of_range) {
  SceneOptions options = scene_options();
  options.cuda_device = -2;
  EXPECT_THROW(const softcd::Scene scene(options), InvalidInput);
  softcd::Scene scene(scene_options());
  QueryOptions query_options;
  query_options.step_end = static_cast<StepEnd>(2);
  EXPECT_THROW(const Query query(scene, query_options), InvalidInput);
  query_options = {};
  query_options.step_end = StepEnd::t0;
  query_options.motion_margin = 1.0F;
  EXPECT_THROW(const Query query(scene, query_options), InvalidInput);
  Query query(scene, {});
  EXPECT_THROW(query.detect(static_cast<Pairs>(2)), InvalidInput);
}

/// Bodies come, go, grow, shrink and move. The contacts are those of a scene that is made in the final state.
class Changes {
 public:
  explicit Changes(std::uint64_t seed) : random_(seed), scene_(scene_options()) {
    queries_.emplace_back(scene_, looking_for(Detection::dcd));
    queries_.emplace_back(scene_, looking_for(Detection::ccd));
  }

  void change() {
    const std::uint32_t what = random_.below(12);
    if (what < 3 || bodies_.empty()) {
      add();
    } else if (what == 3) {
      const auto gone = some_body();
      scene_.remove_body(gone->first);
      bodies_.erase(gone);
    } else if (what < 6) {
      update(some_body());
    } else if (what < 9) {
      move(some_body());
    } else {
      const auto body = some_body();
      body->second.settings.margin = 0.01F * static_cast<float>(random_.below(4));
      body->second.settings.self_collision = random_.chance(0.6);
      scene_.set_settings(body->first, body->second.settings);
    }
  }

  void expect_the_contacts_of_a_fresh_scene() {
    Scene scene;
    std::map<std::uint32_t, std::uint32_t> rank;
    for (const auto& [id, body] : bodies_) {
      rank.emplace(id.value, static_cast<std::uint32_t>(scene.size()));
      scene.push_back(body);
    }
    for (Query& query : queries_) {
      std::vector<Contact> found = copy_of(query.detect());
      for (Contact& contact : found) {
        contact.body_a.value = rank.at(contact.body_a.value);
        contact.body_b.value = rank.at(contact.body_b.value);
      }
      const Outcome expected = outcome_of(scene, alone(query.options()));
      ASSERT_TRUE(identical(expected.contacts, found)) << found.size() << " for " << expected.contacts.size();
      EXPECT_EQ(query.statistics().triangles, expected.statistics.triangles);
      EXPECT_EQ(query.statistics().left_out_triangles, expected.statistics.left_out_triangles);
      contacts_ += found.size();
    }
  }

  std::size_t contacts() const { return contacts_; }

 private:
  using Bodies = std::map<BodyId, SceneBody>;

  Bodies::iterator some_body() {
    return std::next(bodies_.begin(), random_.below(static_cast<std::uint32_t>(bodies_.size())));
  }
  SceneBody some_mesh() { return soup_body(random_.bits(), 1 + random_.below(40)); }

  void add() {
    SceneBody body = some_mesh();
    const BodyId id = scene_.add_body(desc_of(body));
    set_positions(id, bodies_[id] = std::move(body));
  }
  void update(Bodies::iterator body) {
    body->second = some_mesh();
    scene_.update_body(body->first, desc_of(body->second));
    set_positions(body->first, body->second);
  }
  void move(Bodies::iterator entry) {
    SceneBody& body = entry->second;
    body.x_t0 = body.x_t1;
    for (Vec3d& x : body.x_t0) {
      for (double* const coordinate : {&x.x, &x.y, &x.z}) {
        if (!(std::abs(*coordinate) < 100.0)) *coordinate = 0.0;
      }
    }
    body.x_t1 = jittered(body.x_t0, 0.2, random_.bits());
    if (random_.chance(0.2)) body.x_t1[random_.below(static_cast<std::uint32_t>(body.x_t1.size()))].y = NAN;
    if (random_.chance(0.1)) body.x_t1 = translated(body.x_t1, {300.0, 0.0, 0.0});
    set_positions(entry->first, body);
  }
  void set_positions(BodyId id, const SceneBody& body) {
    if (random_.chance(0.3)) {
      bodies_[id].x_t0 = bodies_[id].x_t1;
      scene_.set_positions(id, bodies_[id].x_t1, bodies_[id].x_t1);
    } else {
      scene_.set_positions(id, body.x_t0, body.x_t1);
    }
  }

  Random random_;
  softcd::Scene scene_;
  std::vector<Query> queries_;
  Bodies bodies_;
  std::size_t contacts_ = 0;
};

TEST(Scenes, may_be_changed_in_any_order) {
  std::size_t contacts = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Changes changes(seed);
    for (int step = 0; step < 40; ++step) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", step " << step);
      for (int i = 0; i < 3; ++i) changes.change();
      ASSERT_NO_FATAL_FAILURE(changes.expect_the_contacts_of_a_fresh_scene());
    }
    contacts += changes.contacts();
  }
  EXPECT_GT(contacts, 10'000U);
}

TEST(Scenes, that_are_far_away_keep_floats_as_they_are) {
  Scene nearby = three_soups();
  Scene distant = nearby;
  // Positions that are exact as floats so far away.
  for (SceneBody& body : distant) {
    snap_to_grid(body.x_t0, 12);
    snap_to_grid(body.x_t1, 12);
  }
  nearby = distant;
  for (SceneBody& body : distant) {
    body.x_t0 = translated(body.x_t0, {512.0, -256.0, 0.0});
    body.x_t1 = translated(body.x_t1, {512.0, -256.0, 0.0});
  }
  FilledScene filled(nearby);
  Query query(filled.scene, looking_for(Detection::ccd));
  const std::vector<Contact> expected = copy_of(query.detect());
  // The bodies move there one by one, and the last one moves the scene's origin.
  for (std::size_t b = 0; b < distant.size(); ++b) {
    filled.scene.set_positions(filled.ids[b], distant[b].x_t0, distant[b].x_t1);
    query.detect();
  }
  EXPECT_EQ(features_of(query.detect()), features_of(expected));
  EXPECT_TRUE(identical(detect_once(distant, alone(looking_for(Detection::ccd))), query.detect()));
}

}  // namespace
}  // namespace softcd::test

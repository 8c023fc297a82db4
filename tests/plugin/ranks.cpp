#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "expectations.hpp"
#include "mesh_generators.hpp"
#include "rank_scene.hpp"
#include "scene.hpp"
#include "softcd/pipeline/rank_link.hpp"

// Several ranks, each a thread, detect in one scene: together they work as one detector.
namespace softcd::test {
namespace {

using namespace std::chrono_literals;

SceneBody soup_body(std::uint32_t triangles, double largest, std::uint64_t seed, float margin = 0.02F) {
  SoupOptions options;
  options.triangle_count = triangles;
  options.half_extent = 2.0;
  options.largest = largest;
  options.size_ratio = 4.0;
  options.joined_share = 0.4;
  options.degenerate_share = 0.05;
  options.needle_share = 0.05;
  options.seed = seed;
  const Mesh mesh = triangle_soup(options);
  return moving(mesh, scattered(mesh, 0.3, seed + 100), everything(margin));
}

/// Returns triangles of all sizes: whole, split, and on the list of those tested against all. Also short and long
/// segments.
Scene mixed_sizes() {
  Scene scene{soup_body(900, 0.15, 1), soup_body(900, 0.15, 2), soup_body(12, 6.0, 3)};
  const auto vertex_count = static_cast<std::uint32_t>(scene[0].x_t1.size());
  for (std::uint32_t v = 3; v < vertex_count; v += 61) scene[0].segments.push_back({{v % 3 == 0 ? v / 2 : v - 3, v}});
  const Mesh plate = moved(scaled(grid_cloth(2, 2, 1.0), 9.0), {-4.5, -4.5, 0.1});
  scene.push_back(still(plate, everything(0.01F)));
  return scene;
}

/// Returns a body that touches itself, including neighbours.
Scene crumpled() {
  const Mesh cloth = crumpled_cloth(40, 20, 0.1, 0.05, 7);
  return {moving(cloth, jittered(cloth.positions, 0.06, 9), everything(0.02F)),
          moving(moved(cloth, {0.3, 0.2, 0.03}), jittered(translated(cloth.positions, {0.3, 0.2, 0.03}), 0.06, 10),
                 everything(0.01F))};
}

/// Returns a scene far from the origin, in doubles, with vertices that are not finite.
Scene far_away() {
  Scene scene = mixed_sizes();
  for (SceneBody& body : scene) {
    body.x_t0 = translated(jittered(body.x_t0, 1e-3, 4), {1000.0, -3000.0, 0.5});
    body.x_t1 = translated(jittered(body.x_t1, 1e-3, 5), {1000.0, -3000.0, 0.5});
  }
  scene[0].x_t1[17].y = NAN;
  return scene;
}

Scene advanced(Scene scene) {
  for (SceneBody& body : scene) {
    body.x_t0 = body.x_t1;
    body.x_t1 = translated(body.x_t1, {0.05, -0.02, 0.11});
  }
  return scene;
}

constexpr std::pair<Detection, Accuracy> kWays[] = {{Detection::dcd, Accuracy::fast},
                                                    {Detection::dcd, Accuracy::conservative},
                                                    {Detection::ccd, Accuracy::precise},
                                                    {Detection::ccd, Accuracy::conservative}};

/// Three steps of a scene, and the contacts of one rank.
struct Steps {
  Scene scenes[3];
  std::vector<Contact> contacts[3];
  std::size_t count = 0;

  Steps(const Scene& scene, const PipelineOptions& options) {
    for (std::size_t step = 0; step < 3; ++step) {
      scenes[step] = step == 0 ? scene : advanced(scenes[step - 1]);
      contacts[step] = detect_once(scenes[step], options);
      count += contacts[step].size();
    }
  }
};

/// Expects so many ranks together to find the same contacts, each on one rank.
void expect_same_contacts(const Steps& steps, const PipelineOptions& options, int rank_count) {
  std::atomic<std::size_t> found{0};
  expect_no_problem(in_ranks(Communicator::of_threads(rank_count), [&](const Communicator& rank) {
    RankScene part(steps.scenes[0], rank, options);
    for (std::size_t step = 0; step < 3; ++step) {
      part.set_positions(steps.scenes[step]);
      found += part.query().detect().size();
      EXPECT_TRUE(identical(steps.contacts[step], part.query().gather_contacts()))
          << "rank " << rank.rank() << " of " << rank_count << ", step " << step;
    }
  }));
  EXPECT_EQ(found, steps.count);
}

TEST(Ranks, find_together_what_one_finds) {
  const std::pair<const char*, Scene> scenes[] = {
      {"mixed sizes", mixed_sizes()}, {"crumpled", crumpled()}, {"far away", far_away()}};
  for (const auto& [name, scene] : scenes) {
    for (const auto& [detection, accuracy] : kWays) {
      SCOPED_TRACE(name);
      PipelineOptions options = test_options(detection);
      options.accuracy = accuracy;
      const Steps steps(scene, options);
      EXPECT_GT(steps.count, 300U);
      for (const int ranks : {1, 2, 3, 5, 8}) expect_same_contacts(steps, options, ranks);
    }
  }
}

TEST(Ranks, leave_out_what_filters_do) {
  const PipelineOptions options = test_options(Detection::ccd);
  Scene scene = crumpled();
  for (SceneBody& body : scene) body.settings.neighbour_rings = 3;
  const Steps steps(scene, options);
  EXPECT_LT(steps.count, Steps(crumpled(), options).count);
  for (const int ranks : {2, 5}) expect_same_contacts(steps, options, ranks);
}

TEST(Ranks, share_split_triangles_and_those_tested_against_all_out) {
  const PipelineOptions options = test_options(Detection::ccd);
  const Statistics alone = outcome_of(mixed_sizes(), options).statistics;
  EXPECT_GT(alone.split_triangles, 0U);
  EXPECT_GT(alone.flagged_pairs, 0U);
  EXPECT_GT(alone.big_triangles, 0U);
  const Steps steps(mixed_sizes(), options);
  for (const int ranks : {4, 7}) expect_same_contacts(steps, options, ranks);
}

TEST(Ranks, have_about_as_many_tests_each_once_they_know_where_these_are) {
  constexpr int kRanks = 4;
  // The scene is on one side of the origin, where all cells first belong to the first rank.
  Scene scene{soup_body(3000, 0.2, 1), soup_body(3000, 0.2, 2)};
  for (SceneBody& body : scene) {
    body.x_t0 = translated(body.x_t0, {3.0, 3.0, 3.0});
    body.x_t1 = translated(body.x_t1, {3.0, 3.0, 3.0});
  }
  std::atomic<std::uint64_t> tests[2][kRanks];
  expect_no_problem(in_ranks(Communicator::of_threads(kRanks), [&](const Communicator& rank) {
    RankScene part(scene, rank, test_options(Detection::ccd));
    for (int step = 0; step < 3; ++step) {
      part.set_positions(scene);
      part.query().detect();
      tests[step > 0 ? 1 : 0][rank.rank()] = part.query().statistics().tests;
    }
    const std::vector<StageReport> report = part.query().explain();
    EXPECT_TRUE(std::any_of(report.begin(), report.end(), [](const StageReport& stage) {
      return stage.stage == DetectionStage::ranks && stage.ran && stage.reason.find("of 4 made 2") != std::string::npos;
    }));
  }));
  const auto most = [](const auto& counts) { return std::max_element(std::begin(counts), std::end(counts))->load(); };
  std::uint64_t all = 0;
  for (const auto& count : tests[1]) all += count;
  EXPECT_GT(most(tests[0]), all * 6 / 10);
  EXPECT_LT(most(tests[1]), all * 11 / 40);
}

/// Pairs of triangles need more memory than all else, and some come several times.
Scene crowd() {
  SoupOptions soup;
  soup.triangle_count = 1500;
  soup.half_extent = 0.2;
  soup.largest = 1.8;
  soup.size_ratio = 12.0;
  soup.seed = 8;
  const Mesh mesh = triangle_soup(soup);
  return {moving(mesh, scattered(mesh, 0.002, 9), everything(0.0001F))};
}

TEST(Ranks, in_parts_where_one_has_little_memory) {
  const Scene scene = crowd();
  const PipelineOptions options = test_options(Detection::ccd);
  const Outcome alone = outcome_of(scene, options);
  std::atomic<int> in_parts{0};
  in_ranks(Communicator::of_threads(2), [&](const Communicator& rank) {
    RankScene part(scene, rank, options);
    part.set_positions(scene);
    // The limit falls until all ranks report that it is too low.
    for (std::uint64_t eighths = 8; eighths > 0; --eighths) {
      SceneOptions limited = part.scene().options();
      if (rank.rank() == 1) limited.memory_limit = alone.statistics.peak_bytes * eighths / 8;
      part.scene().set_options(limited);
      part.query().detect();
      in_parts += part.query().statistics().chunks > 1 ? 1 : 0;
      EXPECT_TRUE(identical(alone.contacts, part.query().gather_contacts()));
    }
  });
  EXPECT_GT(in_parts, 0);
}

TEST(Ranks, have_room_for_what_does_not_fit_one) {
  const Scene scene = mixed_sizes();
  const PipelineOptions options = test_options(Detection::ccd);
  const std::vector<Contact> expected = detect_once(scene, options);
  // Finds the least limit that one rank needs, to a twentieth.
  PipelineOptions limited = options;
  for (std::uint64_t limit = outcome_of(scene, options).statistics.peak_bytes;; limit -= limit / 20) {
    limited.memory_limit = limit;
    try {
      detect_once(scene, limited);
    } catch (const OutOfMemory&) {
      break;
    }
  }
  expect_no_problem(in_ranks(Communicator::of_threads(2), [&](const Communicator& rank) {
    RankScene part(scene, rank, limited);
    part.set_positions(scene);
    part.query().detect();
    EXPECT_TRUE(identical(expected, part.query().gather_contacts()));
  }));
}

TEST(Ranks, are_all_told_what_goes_wrong_on_one) {
  const Scene scene = crumpled();
  const PipelineOptions options = test_options(Detection::ccd);
  const std::vector<Contact> expected = detect_once(scene, options);
  std::vector<std::string> problems(3);
  expect_no_problem(in_ranks(Communicator::of_threads(3), [&](const Communicator& rank) {
    PipelineOptions limited = options;
    if (rank.rank() == 1) limited.memory_limit = 1000;
    RankScene part(scene, rank, limited);
    part.set_positions(scene);
    try {
      part.query().detect();
    } catch (const OutOfMemory& error) {
      problems[static_cast<std::size_t>(rank.rank())] = error.what();
    }
    SceneOptions unlimited = part.scene().options();
    unlimited.memory_limit = 0;
    part.scene().set_options(unlimited);
    part.query().detect();
    EXPECT_TRUE(identical(expected, part.query().gather_contacts()));
  }));
  EXPECT_NE(problems[0].find("rank 1: memory ran out"), std::string::npos) << problems[0];
  EXPECT_EQ(problems[1], problems[0]);
  EXPECT_EQ(problems[2], problems[0]);
}

TEST(Ranks, are_told_when_another_does_not_come) {
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<std::string> problems = in_ranks(Communicator::of_threads(3, 100ms), [&](const Communicator& rank) {
    RankScene part(crumpled(), rank, test_options(Detection::dcd));
    if (rank.rank() != 1) part.query().detect();
  });
  EXPECT_NE(problems[0].find("rank 0 of 3: "), std::string::npos) << problems[0];
  EXPECT_EQ(problems[1], "");
  EXPECT_NE(problems[2].find("rank 2 of 3: "), std::string::npos) << problems[2];
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 20s);
}

TEST(Ranks, must_have_the_same_scene_and_queries) {
  const auto problems_of = [](const std::function<void(int rank, Scene&, PipelineOptions&)>& change) {
    std::set<std::string> different;
    for (const std::string& problem : in_ranks(Communicator::of_threads(2), [&](const Communicator& rank) {
           Scene scene = crumpled();
           PipelineOptions options = test_options(Detection::dcd);
           change(rank.rank(), scene, options);
           RankScene part(scene, rank, options);
           part.set_positions(scene);
           part.query().detect();
         })) {
      different.insert(problem);
    }
    return different;
  };
  const std::set<std::string> scenes = problems_of([](int rank, Scene& scene, PipelineOptions&) {
    if (rank == 1) scene.pop_back();
  });
  EXPECT_EQ(scenes,
            (std::set<std::string>{
                "the ranks have different scenes; add the same bodies, with the same settings, on all of them."}));
  const std::set<std::string> queries = problems_of([](int rank, Scene&, PipelineOptions& options) {
    if (rank == 1) options.accuracy = Accuracy::fast;
  });
  EXPECT_EQ(queries,
            (std::set<std::string>{"the ranks start different detections; use queries with the same options on "
                                   "all of them."}));
}

/// Returns how long ranks wait for one that will not come: ten times the present time of a detection, as the machine
/// may be busy.
std::chrono::milliseconds patience_for(const Scene& scene, const PipelineOptions& options, int rank_count) {
  const auto begin = std::chrono::steady_clock::now();
  in_ranks(Communicator::of_threads(rank_count), [&](const Communicator& rank) {
    RankScene part(scene, rank, options);
    part.set_positions(scene);
    part.query().detect();
    part.query().gather_contacts();
  });
  const auto taken = std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - begin);
  return std::max<std::chrono::milliseconds>(100ms, 10 * taken);
}

/// Connects ranks by a function that fails at its n-th call on one of them.
TEST(Ranks, end_with_an_error_whichever_exchange_fails) {
  const Scene scene = crumpled();
  const PipelineOptions options = test_options(Detection::dcd);
  constexpr int kRanks = 3;
  const std::chrono::milliseconds patience = patience_for(scene, options, kRanks);
  for (int failing_rank = 0; failing_rank < kRanks; ++failing_rank) {
    bool has_failed = true;
    for (int failing_call = 0; has_failed; ++failing_call) {
      ASSERT_LT(failing_call, 50);
      has_failed = false;
      const std::vector<Communicator> places = Communicator::of_threads(kRanks, patience);
      const std::vector<std::string> problems = in_ranks(places, [&](const Communicator& place) {
        int calls = 0;
        const Communicator rank(place.rank(), kRanks, [&](const void* mine, std::size_t bytes, void* all) {
          if (place.rank() == failing_rank && calls++ == failing_call) {
            has_failed = true;
            throw std::runtime_error("the wire is cut");
          }
          place.link()->all_gather(mine, bytes, all);
        });
        RankScene part(scene, rank, options);
        part.set_positions(scene);
        part.query().detect();
        part.query().gather_contacts();
      });
      for (int rank = 0; rank < kRanks; ++rank) {
        const std::string& problem = problems[static_cast<std::size_t>(rank)];
        if (!has_failed) {
          EXPECT_EQ(problem, "");
        } else if (rank == failing_rank) {
          EXPECT_EQ(problem, "the wire is cut");
        } else {
          EXPECT_NE(problem, "") << "rank " << rank << ", call " << failing_call;
        }
      }
    }
  }
}

/// Returns communicators on two GPUs, or a reason to skip.
std::vector<Communicator> on_two_gpus(std::string& problem) {
  if (backend_under_test() != Backend::cuda) {
    problem = "not on the GPU";
    return {};
  }
  try {
    const std::vector<int> devices = {0, 1};
    return Communicator::of_devices(devices, 20s);
  } catch (const BackendError& error) {
    problem = error.what();
    return {};
  }
}

TEST(Ranks, on_several_gpus_find_together_what_one_finds) {
  std::string problem;
  const std::vector<Communicator> gpus = on_two_gpus(problem);
  if (gpus.empty()) GTEST_SKIP() << problem;
  const Mesh cloth = crumpled_cloth(340, 200, 0.1, 0.05, 7);
  const Scene scene{moving(cloth, jittered(cloth.positions, 0.06, 9), everything(0.02F)),
                    moving(moved(cloth, {0.3, 0.2, 0.03}),
                           jittered(translated(cloth.positions, {0.3, 0.2, 0.03}), 0.06, 10), everything(0.01F))};
  for (const auto& [detection, accuracy] : kWays) {
    PipelineOptions options = test_options(detection);
    options.accuracy = accuracy;
    const Steps steps(scene, options);
    std::atomic<std::size_t> found{0};
    expect_no_problem(in_ranks(gpus, [&](const Communicator& rank) {
      RankScene part(steps.scenes[0], rank, options);
      for (std::size_t step = 0; step < 3; ++step) {
        part.set_positions(steps.scenes[step]);
        const std::size_t count = part.query().detect().size();
        EXPECT_GT(count, 0U);
        found += count;
        EXPECT_TRUE(identical(steps.contacts[step], part.query().gather_contacts())) << "step " << step;
      }
    }));
    EXPECT_EQ(found, steps.count);
  }
}

TEST(Ranks, on_several_gpus_leave_small_scenes_to_one) {
  std::string problem;
  const std::vector<Communicator> gpus = on_two_gpus(problem);
  if (gpus.empty()) GTEST_SKIP() << problem;
  const Scene scene = crumpled();
  const std::vector<Contact> expected = detect_once(scene, test_options(Detection::ccd));
  expect_no_problem(in_ranks(gpus, [&](const Communicator& rank) {
    RankScene part(scene, rank, test_options(Detection::ccd));
    part.set_positions(scene);
    EXPECT_EQ(part.query().detect().size(), rank.rank() == 0 ? expected.size() : 0U);
    EXPECT_TRUE(identical(expected, part.query().gather_contacts()));
    const std::vector<StageReport> report = part.query().explain();
    EXPECT_TRUE(std::any_of(report.begin(), report.end(), [](const StageReport& stage) {
      return stage.stage == DetectionStage::ranks && !stage.ran;
    }));
  }));
}

TEST(Ranks, set_positions_of_their_own_bodies_only) {
  const std::vector<Communicator> ranks = Communicator::of_threads(2);
  const Scene scene = crumpled();
  RankScene part(scene, ranks[0], test_options(Detection::dcd));
  EXPECT_EQ(error_of([&] { part.scene().set_positions(part.id(1), scene[1].x_t1); }),
            "body 1: its positions are rank 1's to set; this is rank 0.");
  EXPECT_EQ(error_of([&] {
              part.scene().add_body({scene[0].triangles, static_cast<std::uint32_t>(scene[0].x_t1.size()), {}, 2});
            }),
            "body 2: rank is 2; ranks count from 0 to 1, and -1 is all.");
  SceneOptions others = part.scene().options();
  others.communicator = ranks[1];
  EXPECT_EQ(error_of([&] { part.scene().set_options(others); }),
            "a Scene keeps its communicator for as long as it lives; make another Scene.");
  EXPECT_EQ(error_of([] { Communicator::of_threads(0); }), "0 ranks were asked for; there must be at least 1.");
  EXPECT_EQ(error_of([] { Communicator(2, 2, [](const void*, std::size_t, void*) {}); }),
            "rank is 2 of 2; ranks count from 0.");
  EXPECT_EQ(error_of([] { Communicator(0, 2, {}); }),
            "all_gather is empty; give a function that works like MPI_Allgather.");
}

/// Each position twice, the second time elsewhere, as in an array of structs.
Positions3 with_gaps(const Positions3& x) {
  Positions3 spread;
  for (const Vec3d& p : x) spread.insert(spread.end(), {p, {-p.x, p.z, 7.0}});
  return spread;
}

TEST(Ranks, tell_each_other_positions_that_lie_apart) {
  const Scene scene{soup_body(100, 1.0, 1), soup_body(100, 1.0, 2)};
  Scene one_end = scene;
  for (SceneBody& body : one_end) body.x_t0 = body.x_t1;
  const PipelineOptions options = test_options(Detection::dcd);
  const std::vector<Contact> expected = detect_once(one_end, options);
  ASSERT_FALSE(expected.empty());
  expect_no_problem(in_ranks(Communicator::of_threads(2), [&](const Communicator& rank) {
    RankScene part(scene, rank, options);
    const auto own = static_cast<std::size_t>(rank.rank());
    const Positions3 spread = with_gaps(scene[own].x_t1);
    const Positions positions(&spread[0].x, scene[own].x_t1.size(), 2 * sizeof(Vec3d));
    part.scene().set_positions(part.id(own), positions);
    part.query().detect();
    EXPECT_TRUE(identical(expected, part.query().gather_contacts()));
  }));
}

TEST(Ranks, tell_each_other_both_ends_that_begin_at_one_address) {
  const Scene scene{soup_body(100, 1.0, 1), soup_body(100, 1.0, 2)};
  const PipelineOptions options = test_options(Detection::ccd);
  std::vector<Positions3> all;
  Scene moving_by_strides = scene;
  for (SceneBody& body : moving_by_strides) {
    Positions3 nodes = with_gaps(body.x_t1);
    body.x_t0.assign(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(body.x_t1.size()));
    all.push_back(std::move(nodes));
  }
  const std::vector<Contact> expected = detect_once(moving_by_strides, options);
  ASSERT_FALSE(expected.empty());
  expect_no_problem(in_ranks(Communicator::of_threads(2), [&](const Communicator& rank) {
    RankScene part(scene, rank, options);
    const auto own = static_cast<std::size_t>(rank.rank());
    const std::size_t count = scene[own].x_t1.size();
    part.scene().set_positions(part.id(own), Positions(&all[own][0].x, count, sizeof(Vec3d)),
                               Positions(&all[own][0].x, count, 2 * sizeof(Vec3d)));
    part.query().detect();
    EXPECT_TRUE(identical(expected, part.query().gather_contacts()));
  }));
}

}  // namespace
}  // namespace softcd::test

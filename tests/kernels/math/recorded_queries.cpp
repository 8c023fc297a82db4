#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "exact_ccd.hpp"
#include "ground_truth.hpp"
#include "queries.hpp"
#include "recorded_queries.hpp"
#include "scene_geometry.hpp"

// Queries of simulations with exact verdicts by other authors. Skipped where the data is missing.
namespace softcd::test {
namespace {

namespace fs = std::filesystem;

struct Tally {
  std::size_t queries = 0;
  std::size_t collisions = 0;
  std::size_t missed = 0;
  std::size_t false_alarms = 0;
  double nanoseconds = 0.0;
};

/// Compares verdicts with `collides`, and measures the time of a query.
template <class Decide>
Tally judge_by(const Decide& decide, const std::vector<Query>& queries, const std::vector<bool>& collides) {
  Tally tally;
  tally.queries = queries.size();
  const auto start = std::chrono::steady_clock::now();
  std::vector<bool> hits(queries.size());
  for (std::size_t i = 0; i < queries.size(); ++i) hits[i] = decide(queries[i]) != ImpactState::separated;
  const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - start;
  tally.nanoseconds = elapsed.count() / static_cast<double>(queries.size());
  for (std::size_t i = 0; i < queries.size(); ++i) {
    tally.collisions += collides[i] ? 1 : 0;
    tally.missed += collides[i] && !hits[i] ? 1 : 0;
    tally.false_alarms += !collides[i] && hits[i] ? 1 : 0;
  }
  return tally;
}

template <class T>
Tally judge(const std::vector<Query>& queries, const std::vector<bool>& collides) {
  return judge_by([](const Query& query) { return impact_of<T>(query, T(0)).state; }, queries, collides);
}

Tally judge_approach(const std::vector<Query>& queries, const std::vector<bool>& collides) {
  return judge_by([](const Query& query) { return approach_of(query, 0.0).state; }, queries, collides);
}

void print(const std::string& what, const Tally& tally) {
  std::printf("%s: %zu queries, %zu collide, %zu missed, %zu false alarms, %.0f ns a query\n", what.c_str(),
              tally.queries, tally.collisions, tally.missed, tally.false_alarms, tally.nanoseconds);
}

TEST(RecordedQueries, the_oracle_agrees_with_the_recorded_verdicts) {
  const fs::path folder = data_folder("ccd-queries");
  if (folder.empty()) GTEST_SKIP() << missing_data("ccd-queries");
  const std::vector<RecordedQuery> queries = read_recorded_queries(folder);
  ASSERT_FALSE(queries.empty());
  for (const RecordedQuery& query : queries) {
    const bool verdict = query.kind == ContactKind::vertex_triangle ? collides_vertex_triangle(query.coordinates)
                                                                    : collides_edge_edge(query.coordinates);
    ASSERT_EQ(verdict, query.collides) << to_string(to_double(query));
  }
}

TEST(RecordedQueries, precise_misses_none) {
  const fs::path folder = data_folder("ccd-queries");
  if (folder.empty()) GTEST_SKIP() << missing_data("ccd-queries");
  std::vector<Query> queries;
  std::vector<bool> verdicts;
  std::size_t changed = 0;
  for (const RecordedQuery& recorded : read_recorded_queries(folder)) {
    queries.push_back(to_double(recorded));
    verdicts.push_back(collides(queries.back()));
    changed += verdicts.back() != recorded.collides ? 1 : 0;
  }
  std::printf("%zu verdicts change when coordinates are rounded to double\n", changed);
  const Tally precise = judge<double>(queries, verdicts);
  print("double", precise);
  print("float on double coordinates", judge<float>(queries, verdicts));
  EXPECT_EQ(precise.missed, 0u);
  const Tally approach = judge_approach(queries, verdicts);
  print("approach", approach);
  EXPECT_EQ(approach.missed, 0u);
}

class RecordedSteps : public ::testing::TestWithParam<const char*> {};

TEST_P(RecordedSteps, precise_misses_none_of_the_listed_pairs) {
  const fs::path folder = data_folder("ccd-steps");
  if (folder.empty()) GTEST_SKIP() << missing_data("ccd-steps");
  const GroundTruth truth = read_ground_truth(folder, GetParam());
  const SceneGeometry geometry(truth.scene);
  for (const ContactKind kind : {ContactKind::vertex_triangle, ContactKind::edge_edge}) {
    const std::string name = std::string(GetParam()) + (kind == ContactKind::vertex_triangle ? " VT" : " EE");
    std::vector<Query> queries;
    std::vector<bool> verdicts;
    for (std::size_t i = 0; i < truth.listed.size(); ++i) {
      if (truth.listed[i].kind != kind) continue;
      queries.push_back({kind, geometry.motion(truth.listed[i])});
      verdicts.push_back(truth.collides[i]);
    }
    ASSERT_FALSE(queries.empty());
    const Tally precise = judge<double>(queries, verdicts);
    print(name + " double", precise);
    print(name + " float", judge<float>(queries, verdicts));
    EXPECT_EQ(precise.missed, 0u);
    EXPECT_EQ(precise.false_alarms, 0u);
    const Tally approach = judge_approach(queries, verdicts);
    print(name + " approach", approach);
    EXPECT_EQ(approach.missed, 0u);
    EXPECT_EQ(approach.false_alarms, 0u);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      ASSERT_EQ(collides(queries[i]), verdicts[i]) << to_string(queries[i]);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Steps, RecordedSteps, ::testing::Values("cloth-ball", "armadillo-rollers"),
                         [](const auto& suite) {
                           return std::string(suite.param) == "cloth-ball" ? "cloth_ball" : "armadillo_rollers";
                         });

}  // namespace
}  // namespace softcd::test

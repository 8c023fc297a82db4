#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "ground_truth.hpp"
#include "queries.hpp"

// Judges single queries: which touching features each mode finds during a step, when, and at what cost.

namespace softcd::benchmarks {

struct QuerySet {
  std::string name;
  ContactKind kind;
  std::vector<test::Query> queries;
};

/// Generates queries of random features, and of deliberately hard ones.
std::vector<QuerySet> generate_queries(std::size_t count);

/// Reads a folder's recorded queries, as a set for either kind. Throws std::runtime_error.
std::vector<QuerySet> read_query_sets(const std::filesystem::path& folder);

/// Returns the listed pairs of a recorded step.
std::vector<QuerySet> queries_of_step(const std::string& name, const test::GroundTruth& truth);

/// Differences from the exact time of impact that are beyond its bracket; NaN when there are none.
struct TimeErrors {
  std::size_t count = 0;
  double median = std::numeric_limits<double>::quiet_NaN();
  double permille_999 = std::numeric_limits<double>::quiet_NaN();
  double most = std::numeric_limits<double>::quiet_NaN();
};

struct QueryResult {
  std::string set;
  ContactKind kind;
  std::string mode;
  double margin = 0;  ///< of discrete modes
  std::size_t queries = 0;
  std::size_t touching = 0;  ///< in exact arithmetic
  std::size_t missed = 0;
  std::size_t false_alarms = 0;
  TimeErrors early, late;  ///< of touching pairs that were found
  double nanoseconds = 0;  ///< of processor time, per query
};

/// Measures each mode. Times are medians of `repetitions` rounds.
std::vector<QueryResult> measure_queries(const QuerySet& set, int repetitions);

}  // namespace softcd::benchmarks

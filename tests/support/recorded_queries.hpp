#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "exact_ccd.hpp"
#include "queries.hpp"

namespace softcd::test {

/// A query as it was recorded, with somebody else's exact verdict.
struct RecordedQuery {
  ContactKind kind;
  std::array<Fraction, 24> coordinates;
  bool collides;
};

/// All queries of the CSV files under a folder, in which those in folders named edge-edge are of edges; in the order
/// of the files' names. Throws std::runtime_error when a file is not as expected.
std::vector<RecordedQuery> read_recorded_queries(const std::filesystem::path& folder);

/// Every coordinate rounded to double.
Query to_double(const RecordedQuery& recorded);

}  // namespace softcd::test

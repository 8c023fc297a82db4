#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "exact_ccd.hpp"
#include "queries.hpp"

namespace softcd::test {

/// A recorded query, with the exact verdict of its authors.
struct RecordedQuery {
  ContactKind kind;
  std::array<Fraction, 24> coordinates;
  bool collides;
};

/// Returns all queries of the CSV files under a folder, in the order of the files' names. Those in folders named
/// edge-edge are of edges. Throws std::runtime_error when a file is not as expected.
std::vector<RecordedQuery> read_recorded_queries(const std::filesystem::path& folder);

/// Returns the query with every coordinate rounded to double.
Query to_double(const RecordedQuery& recorded);

}  // namespace softcd::test

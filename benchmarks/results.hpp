#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "softcd/core/statistics.hpp"

namespace softcd::benchmarks {

/// One row of `softcd-bench detector --json`.
struct ResultRow {
  /// What was measured: scene, triangles, backend, detection with accuracy, and the dials that do not stand as the
  /// sweep `stages` has them. Rows with the same are compared.
  std::array<std::string, 5> settings;
  std::string left_out;  ///< why there are no figures; empty: there are
  StageTimes ms;         ///< medians
  /// Between these, `ms.total` varies.
  double low_ms = 0, high_ms = 0;
  std::uint64_t peak_bytes = 0;
  std::string checksum;                                       ///< of the contacts
  std::vector<std::pair<std::string, std::uint64_t>> counts;  ///< of cells, tests, contacts and so on, by name
};

struct Results {
  std::string origin;  ///< machine, date and compiler
  std::vector<ResultRow> rows;
};

/// What `softcd-bench detector --json` wrote. A row varies between its quartiles, or not at all in files without them.
/// Throws std::runtime_error, naming the file, when it is something else.
Results read_results(const std::string& file);

/// Medians over several runs of one build; a row varies between their quartiles. Throws std::runtime_error when they
/// did not measure or did not find the same.
Results merge(const std::vector<Results>& runs);

}  // namespace softcd::benchmarks

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
  /// The settings: scene, triangles, backend, detection with accuracy, and the other options that differ from those
  /// of the sweep `stages`. Rows with the same settings are compared.
  std::array<std::string, 5> settings;
  std::string left_out;  ///< the reason why there are no figures; empty: there are figures
  StageTimes ms;         ///< medians
  /// The range of `ms.total`.
  double low_ms = 0, high_ms = 0;
  std::uint64_t peak_bytes = 0;
  std::string checksum;                                       ///< of the contacts
  std::vector<std::pair<std::string, std::uint64_t>> counts;  ///< of cells, tests, contacts and so on, by name
};

struct Results {
  std::string origin;  ///< machine, date and compiler
  std::vector<ResultRow> rows;
};

/// Reads the output of `softcd-bench detector --json`. A row varies between its quartiles, or not at all in files
/// without them. Throws std::runtime_error, naming the file, when it is something else.
Results read_results(const std::string& file);

/// Returns medians over several runs of one build. A row varies between their quartiles. Throws std::runtime_error when
/// the runs differ in measurements or contacts.
Results merge(const std::vector<Results>& runs);

}  // namespace softcd::benchmarks

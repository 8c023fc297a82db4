#pragma once

#include <vector>

#include "pair_selection.hpp"
#include "softcd/query.hpp"

namespace softcd {

/// The facts that decide which stages a detection runs.
struct Decisions {
  std::uint64_t body_count = 0;
  std::uint64_t pair_count = 0;
  std::uint64_t self_count = 0;
  bool vertex_triangle = false;
  bool edge_edge = false;
  bool moves = false;                   ///< in a continuous detection: some vertex moves
  std::uint64_t without_positions = 0;  ///< number of bodies
  Accuracy accuracy = Accuracy::precise;
  const char* accuracy_reason = "";
  int rank = 0;
  int rank_count = 1;
  std::uint64_t fewest_triangles_of_ranks = 0;  ///< a scene with fewer triangles is detected by one rank alone
  double share_of_tests = 1.0;                  ///< on this rank
};

std::vector<StageReport> explain_stages(const QueryOptions& options, const Decisions& decisions,
                                        const std::string& backend_reason, const Statistics& statistics);

}  // namespace softcd

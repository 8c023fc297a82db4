#include "explain.hpp"

#include <fmt/format.h>

namespace softcd {
namespace {

StageReport explain_grid(const QueryOptions& options, const Statistics& statistics) {
  if (statistics.reused_pairs) {
    return {"broad phase", false,
            fmt::format("all triangles, or all but a few that were looked up, are within their volumes of an "
                        "earlier detection, whose {} pairs were tested",
                        statistics.tests)};
  }
  if (options.broad_phase == BroadPhase::uniform) {
    return {"broad phase: uniform", true,
            fmt::format("asked for; cells of {:.4g} fit the largest triangle", statistics.cell_size)};
  }
  return {"broad phase: exact", true,
          fmt::format("cells of {:.4g}, {} of {} triangles can reach a partner", statistics.cell_size,
                      statistics.active_triangles, statistics.triangles)};
}

StageReport explain_sweep(const QueryOptions& options, const Decisions& decisions) {
  const char* const stage = "swept volumes";
  if (options.detection == Detection::dcd) return {stage, false, "discrete detection was asked for"};
  if (!decisions.moves) return {stage, false, "nothing moves in this step"};
  return {stage, true, "vertices move in this step; time slabs for pairs that move further than they are wide"};
}

StageReport explain_subdivision(const QueryOptions& options, const Statistics& statistics) {
  const char* const stage = "virtual subdivision";
  if (!options.subdivision) return {stage, false, "switched off"};
  if (options.broad_phase == BroadPhase::uniform)
    return {stage, false, "the uniform grid's cells fit the largest triangle"};
  if (statistics.split_triangles == 0) return {stage, false, "no triangle is too large for its cells"};
  return {stage, true, fmt::format("{} triangles are larger than a cell allows", statistics.split_triangles)};
}

StageReport explain_big(const Statistics& statistics) {
  if (statistics.big_triangles == 0) return {"tests against all", false, "no triangle needs too many cells"};
  return {"tests against all", true,
          fmt::format("{} triangles would take more cells than they are worth", statistics.big_triangles)};
}

StageReport explain_ranks(const Decisions& decisions, const Statistics& statistics) {
  const std::uint64_t fewest = decisions.fewest_triangles_of_ranks;
  if (statistics.triangles < fewest) {
    return {"ranks", false,
            fmt::format("rank 0 alone detects {} triangles, fewer than {}, faster than several ranks",
                        statistics.triangles, fewest)};
  }
  return {"ranks", true,
          fmt::format("rank {} of {} made {:.1f} % of the tests", decisions.rank, decisions.rank_count,
                      100.0 * decisions.share_of_tests)};
}

StageReport explain_kind(const char* stage, bool wanted, std::uint64_t candidates) {
  if (!wanted) return {stage, false, "no two bodies that may touch both want it"};
  return {stage, true, fmt::format("{} candidates", candidates)};
}

const char* name_of(Accuracy accuracy) {
  if (accuracy == Accuracy::conservative) return "accuracy: conservative";
  return accuracy == Accuracy::precise ? "accuracy: precise" : "accuracy: fast";
}

}  // namespace

std::vector<StageReport> explain_stages(const QueryOptions& options, const Decisions& decisions,
                                        const std::string& backend_reason, const Statistics& statistics) {
  std::vector<StageReport> report;
  const char* const backend = statistics.backend == Backend::cuda ? "backend: cuda" : "backend: cpu";
  report.push_back({backend, true, backend_reason});
  const bool any = decisions.pair_count + decisions.self_count > 0;
  report.push_back({"body pairs", true,
                    fmt::format("{} pairs of {} bodies and {} bodies with themselves may touch", decisions.pair_count,
                                decisions.body_count, decisions.self_count)});
  if (decisions.without_positions > 0) {
    report.push_back({"bodies without positions", false,
                      fmt::format("{} bodies are left out until theirs are set", decisions.without_positions)});
  }
  if (!any) {
    report.push_back(
        {"detection", false, "no two bodies may touch, by their groups, masks, features, boxes and the pair filter"});
    return report;
  }
  if (decisions.rank_count > 1) report.push_back(explain_ranks(decisions, statistics));
  report.push_back(explain_grid(options, statistics));
  report.push_back(explain_sweep(options, decisions));
  report.push_back(explain_subdivision(options, statistics));
  report.push_back(explain_big(statistics));
  if (statistics.chunks > 1) {
    report.push_back(
        {"pair tests in parts", true, fmt::format("{} parts, so that memory suffices", statistics.chunks)});
  }
  report.push_back({name_of(decisions.accuracy), true, decisions.accuracy_reason});
  report.push_back(explain_kind("vertex-triangle tests", decisions.vertex_triangle, statistics.vt_candidates));
  report.push_back(explain_kind("edge-edge tests", decisions.edge_edge, statistics.ee_candidates));
  const bool continuous = options.detection == Detection::ccd;
  report.push_back({"time of impact", continuous,
                    continuous ? "continuous detection was asked for" : "discrete detection was asked for"});
  return report;
}

}  // namespace softcd

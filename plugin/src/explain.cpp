#include "explain.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "softcd/fields/options.hpp"

namespace softcd {
namespace {

using Stage = DetectionStage;

/// An enumerator in words: "broad phase" for `broad_phase`.
template <auto kEnumerator>
inline constexpr auto kInWords = [] {
  auto words = kNameInSource<kEnumerator>;
  for (char& c : words) c = c == '_' ? ' ' : c;
  return words;
}();

template <std::uint32_t... kValue>
constexpr std::array<const char*, sizeof...(kValue)> all_in_words(
    std::integer_sequence<std::uint32_t, kValue...> /*values*/) {
  return {kInWords<Stage{kValue}>.data()...};
}
constexpr auto kStagesInWords = all_in_words(std::make_integer_sequence<std::uint32_t, kEnumerators<Stage>.size()>());

template <class Enum>
const char* enumerator_name(Enum value) {
  return kEnumerators<Enum>[static_cast<std::uint32_t>(value)];
}

StageReport explain_grid(const QueryOptions& options, const Statistics& statistics) {
  if (statistics.reused_pairs) {
    return {Stage::broad_phase, false,
            fmt::format("all triangles, or all but a few that were looked up, are within their volumes of an "
                        "earlier detection, whose {} pairs were tested",
                        statistics.tests)};
  }
  if (options.broad_phase == BroadPhase::uniform) {
    return {Stage::broad_phase, true,
            fmt::format("uniform: asked for; cells of {:.4g} fit the largest triangle", statistics.cell_size)};
  }
  return {Stage::broad_phase, true,
          fmt::format("exact: cells of {:.4g}, {} of {} triangles can reach a partner", statistics.cell_size,
                      statistics.active_triangles, statistics.triangles)};
}

StageReport explain_sweep(const QueryOptions& options, const Decisions& decisions) {
  constexpr Stage stage = Stage::swept_volumes;
  if (options.detection == Detection::dcd) return {stage, false, "discrete detection was asked for"};
  if (!decisions.moves) return {stage, false, "nothing moves in this step"};
  return {stage, true, "vertices move in this step; time slabs for pairs that move further than they are wide"};
}

StageReport explain_subdivision(const QueryOptions& options, const Statistics& statistics) {
  constexpr Stage stage = Stage::virtual_subdivision;
  if (!options.subdivision) return {stage, false, "switched off"};
  if (options.broad_phase == BroadPhase::uniform)
    return {stage, false, "the uniform grid's cells fit the largest triangle"};
  if (statistics.split_triangles == 0) return {stage, false, "no triangle is too large for its cells"};
  return {stage, true, fmt::format("{} triangles are larger than a cell allows", statistics.split_triangles)};
}

StageReport explain_big(const Statistics& statistics) {
  constexpr Stage stage = Stage::tests_against_all;
  if (statistics.big_triangles == 0) return {stage, false, "no triangle needs too many cells"};
  return {stage, true, fmt::format("{} triangles would take more cells than they are worth", statistics.big_triangles)};
}

StageReport explain_ranks(const Decisions& decisions, const Statistics& statistics) {
  const std::uint64_t fewest = decisions.fewest_triangles_of_ranks;
  if (statistics.triangles < fewest) {
    return {Stage::ranks, false,
            fmt::format("rank 0 alone detects {} triangles, fewer than {}, faster than several ranks",
                        statistics.triangles, fewest)};
  }
  return {Stage::ranks, true,
          fmt::format("rank {} of {} made {:.1f} % of the tests", decisions.rank, decisions.rank_count,
                      100.0 * decisions.share_of_tests)};
}

StageReport explain_kind(Stage stage, bool wanted, std::uint64_t candidates) {
  if (!wanted) return {stage, false, "no two bodies that may touch both want it"};
  return {stage, true, fmt::format("{} candidates", candidates)};
}

/// Reports on a detection between bodies that may touch.
void explain_comparison(const QueryOptions& options, const Decisions& decisions, const Statistics& statistics,
                        std::vector<StageReport>& report) {
  if (decisions.rank_count > 1) report.push_back(explain_ranks(decisions, statistics));
  report.push_back(explain_sweep(options, decisions));
  report.push_back(explain_subdivision(options, statistics));
  report.push_back(explain_grid(options, statistics));
  report.push_back(explain_big(statistics));
  if (statistics.chunks > 1) {
    report.push_back(
        {Stage::tests_in_parts, true, fmt::format("{} parts, so that memory suffices", statistics.chunks)});
  }
  report.push_back(
      {Stage::accuracy, true, fmt::format("{}: {}", enumerator_name(decisions.accuracy), decisions.accuracy_reason)});
  report.push_back(explain_kind(Stage::vertex_triangle_tests, decisions.vertex_triangle, statistics.vt_candidates));
  report.push_back(explain_kind(Stage::edge_edge_tests, decisions.edge_edge, statistics.ee_candidates));
  const bool continuous = options.detection == Detection::ccd;
  report.push_back({Stage::time_of_impact, continuous,
                    continuous ? "continuous detection was asked for" : "discrete detection was asked for"});
}

}  // namespace

const char* softcd::name_of(DetectionStage stage) {
  const auto place = static_cast<std::uint32_t>(stage);
  return place < kStagesInWords.size() ? kStagesInWords[place] : "unknown";
}

std::vector<StageReport> explain_stages(const QueryOptions& options, const Decisions& decisions,
                                        const std::string& backend_reason, const Statistics& statistics) {
  std::vector<StageReport> report;
  report.push_back({Stage::backend, true, fmt::format("{}: {}", enumerator_name(statistics.backend), backend_reason)});
  if (decisions.without_positions > 0) {
    report.push_back({Stage::positions, false,
                      fmt::format("{} bodies are left out until theirs are set", decisions.without_positions)});
  }
  report.push_back({Stage::body_pairs, true,
                    fmt::format("{} pairs of {} bodies and {} bodies with themselves may touch", decisions.pair_count,
                                decisions.body_count, decisions.self_count)});
  if (decisions.pair_count + decisions.self_count > 0) {
    explain_comparison(options, decisions, statistics, report);
  } else {
    report.push_back({Stage::broad_phase, false,
                      "no two bodies may touch, by their groups, masks, features, boxes and the pair filter"});
  }
  return report;
}

}  // namespace softcd

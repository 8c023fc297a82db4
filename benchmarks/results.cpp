#include "results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "command_line/stage_times.hpp"
#include "quartiles.hpp"

namespace softcd::benchmarks {
namespace {

using nlohmann::json;

constexpr const char* kCounts[] = {"split_triangles", "children",      "big_triangles",  "entries",
                                   "cells",           "tests",         "triangle_pairs", "flagged_pairs",
                                   "vt_candidates",   "ee_candidates", "vt_contacts",    "ee_contacts"};

/// The name of the option `cell_size_factor` in results of old builds.
constexpr const char* kOldCellSizeFactor = "lambda";

double cell_size_factor_of(const json& row) {
  return row.contains(kOldCellSizeFactor) ? row.at(kOldCellSizeFactor) : row.at("cell_size_factor");
}

std::string dials_of(const json& row) {
  std::vector<std::string> dials;
  std::string sweep = row.at("sweep");
  if (sweep == kOldCellSizeFactor) sweep = "cell_size_factor";
  if (sweep != "stages") dials.push_back(sweep);
  const std::string broad_phase = row.at("broad_phase");
  if (broad_phase != "exact") dials.push_back(broad_phase);
  if (!row.at("subdivision").get<bool>()) dials.emplace_back("subdivision off");
  if (const double factor = cell_size_factor_of(row); factor != 0) dials.push_back(fmt::format("{:.1f}", factor));
  if (row.value("ends", "host") == "device") dials.emplace_back("ends on device");
  if (row.value("reuse_pairs", false)) dials.emplace_back("reuse of pairs");
  if (row.value("rocks", false)) dials.emplace_back("to and fro");
  if (sweep == "threads") dials.push_back(fmt::format("of {}", row.at("threads").get<int>()));
  return fmt::format("{}", fmt::join(dials, ", "));
}

ResultRow to_row(const json& row) {
  ResultRow result;
  result.settings = {
      row.at("scene"), fmt::to_string(row.value("triangles", std::uint64_t{0})), row.at("backend"),
      fmt::format("{} {}", row.at("detection").get<std::string>(), row.at("accuracy").get<std::string>()),
      dials_of(row)};
  result.left_out = row.value("left_out", "");
  if (!result.left_out.empty()) return result;
  for (const demo::StageTime& stage : demo::kStageTimes) result.ms.*stage.ms = row.at("ms").at(stage.name);
  const json quartiles = row.value("total_ms_quartiles", json::object());
  result.low_ms = quartiles.value("first", result.ms.total);
  result.high_ms = quartiles.value("third", result.ms.total);
  result.peak_bytes = row.at("peak_bytes");
  result.checksum = row.at("contacts_checksum");
  for (const char* count : kCounts) result.counts.emplace_back(count, row.at(count).get<std::uint64_t>());
  return result;
}

void require_distinct(const std::vector<ResultRow>& rows) {
  std::set<std::array<std::string, 5>> seen;
  for (const ResultRow& row : rows) {
    if (!seen.insert(row.settings).second) {
      throw std::runtime_error(fmt::format("two rows are of {}", fmt::join(row.settings, " ")));
    }
  }
}

ResultRow merge_rows(const std::vector<Results>& runs, std::size_t index) {
  ResultRow result = runs.front().rows[index];
  std::vector<StageTimes> times;
  std::vector<double> totals;
  for (const Results& run : runs) {
    const ResultRow& row = run.rows.at(index);
    if (row.settings != result.settings || row.left_out != result.left_out || row.checksum != result.checksum) {
      throw std::runtime_error(
          fmt::format("{}: two runs of one build did not measure or find the same", fmt::join(result.settings, " ")));
    }
    times.push_back(row.ms);
    totals.push_back(row.ms.total);
    result.peak_bytes = std::max(result.peak_bytes, row.peak_bytes);
  }
  const Quartiles quartiles = quartiles_of(totals);
  result.low_ms = quartiles.first;
  result.high_ms = quartiles.third;
  result.ms = demo::median(times);
  return result;
}

}  // namespace

Results read_results(const std::string& file) {
  try {
    std::ifstream stream(file);
    const json content = json::parse(stream);
    if (content.at("benchmark") != "detector") throw std::runtime_error("it is of another benchmark");
    Results results;
    results.origin = fmt::format("{}, {}, {}", content.at("machine").get<std::string>(),
                                 content.at("date").get<std::string>(), content.at("compiler").get<std::string>());
    for (const json& row : content.at("rows")) results.rows.push_back(to_row(row));
    require_distinct(results.rows);
    return results;
  } catch (const std::exception& error) {
    throw std::runtime_error(fmt::format("{}: is no result of softcd-bench detector --json ({})", file, error.what()));
  }
}

Results merge(const std::vector<Results>& runs) {
  Results result = runs.front();
  for (std::size_t i = 0; i < result.rows.size(); ++i) result.rows[i] = merge_rows(runs, i);
  return result;
}

}  // namespace softcd::benchmarks

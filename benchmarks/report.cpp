#include "report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "softcd/version.hpp"

#ifdef SOFTCD_BENCH_HAS_BULLET
#include "LinearMath/btScalar.h"
#endif

namespace softcd::benchmarks {

namespace {

/// Returns the row with nested objects flattened: a.b for b in a.
nlohmann::ordered_json flat(const nlohmann::ordered_json& row) {
  nlohmann::ordered_json result;
  for (const auto& [key, value] : row.items()) {
    if (!value.is_object()) {
      result[key] = value;
      continue;
    }
    for (const auto& [inner_key, inner] : value.items()) result[fmt::format("{}.{}", key, inner_key)] = inner;
  }
  return result;
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("model name", 0) == 0) {
      return fmt::format("{}, {} cores", line.substr(line.find(": ") + 2), std::thread::hardware_concurrency());
    }
  }
  return fmt::format("{} cores", std::thread::hardware_concurrency());
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm day{};
  gmtime_r(&now, &day);
  return fmt::format("{:04}-{:02}-{:02}", day.tm_year + 1900, day.tm_mon + 1, day.tm_mday);
}

}  // namespace

nlohmann::ordered_json describe_run(const std::string& benchmark, const std::string& machine) {
  nlohmann::ordered_json json = {{"benchmark", benchmark},
                                 {"machine", machine.empty() ? processor() : machine},
                                 {"date", today()},
                                 {"compiler", kCompiler},
                                 {"softcd", SOFTCD_VERSION_STRING}};
#ifdef SOFTCD_BENCH_HAS_BULLET
  json["bullet"] = fmt::format("{}.{:02}", BT_BULLET_VERSION / 100, BT_BULLET_VERSION % 100);
#endif
  return json;
}

Table::Table(std::vector<std::string> header, std::size_t text_columns) : text_columns_(text_columns) {
  rows_.push_back(std::move(header));
}

void Table::add(std::vector<std::string> row) {
  row.resize(rows_.front().size());
  rows_.push_back(std::move(row));
}

std::string Table::text() const {
  std::vector<std::size_t> widths(rows_.front().size(), 3);
  for (const auto& row : rows_) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      text += c < text_columns_ ? fmt::format("| {:<{}} ", rows_[r][c], widths[c])
                                : fmt::format("| {:>{}} ", rows_[r][c], widths[c]);
    }
    text += "|\n";
    if (r > 0) continue;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      text +=
          c < text_columns_ ? fmt::format("|:{:-<{}}", "", widths[c] + 1) : fmt::format("|{:-<{}}:", "", widths[c] + 1);
    }
    text += "|\n";
  }
  return text;
}

std::string csv_of(const nlohmann::ordered_json& rows) {
  std::string text;
  const nlohmann::ordered_json header = flat(rows.at(0));
  for (const auto& [key, value] : header.items()) text += (text.empty() ? "" : ",") + key;
  for (const auto& nested : rows) {
    const nlohmann::ordered_json row = flat(nested);
    text += "\n";
    const char* separator = "";
    for (const auto& [key, unused] : header.items()) {
      text += separator;
      separator = ",";
      const nlohmann::ordered_json value = row.value(key, nlohmann::ordered_json());
      const bool is_absent = value.is_null() || (value.is_number_float() && !std::isfinite(value.get<double>()));
      if (is_absent) continue;
      const std::string field = value.is_string() ? value.get<std::string>() : value.dump();
      text += field.find(',') == std::string::npos ? field : '"' + field + '"';
    }
  }
  return text + "\n";
}

void write_file(const std::string& file, const std::string& content) {
  std::ofstream stream(file, std::ios::binary);
  stream << content;
  stream.close();
  if (!stream) throw std::runtime_error(fmt::format("{}: cannot be written (does its folder exist?)", file));
}

void write_json(const std::string& file, const nlohmann::ordered_json& json) {
  write_file(file, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace softcd::benchmarks

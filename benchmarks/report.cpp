#include "report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace softcd::benchmarks {

namespace {

/// With a.b for b in a.
nlohmann::ordered_json flat(const nlohmann::ordered_json& row) {
  nlohmann::ordered_json result;
  for (const auto& [key, value] : row.items()) {
    if (!value.is_object()) {
      result[key] = value;
      continue;
    }
    for (const auto& [inner_key, inner] : value.items()) result[key + "." + inner_key] = inner;
  }
  return result;
}

}  // namespace

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

}  // namespace softcd::benchmarks

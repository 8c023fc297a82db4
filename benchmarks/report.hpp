#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace softcd::benchmarks {

/// The compiler of this program.
#ifdef __clang__
inline constexpr const char* kCompiler = __VERSION__;
#else
inline constexpr const char* kCompiler = "g++ " __VERSION__;
#endif

/// What results begin with: the benchmark, where, when and with what it ran. An empty `machine` is told by its
/// processor.
nlohmann::ordered_json describe_run(const std::string& benchmark, const std::string& machine);

/// A Markdown table whose columns are aligned for terminals too: text to the left, numbers to the right.
class Table {
 public:
  /// `text_columns` of `header` come first and hold text.
  Table(std::vector<std::string> header, std::size_t text_columns);

  void add(std::vector<std::string> row);
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
  std::size_t text_columns_;
};

/// Objects as comma-separated values under a line of the first one's keys, a.b for b in a; what is null or absent
/// becomes empty. Text has no quotation marks.
std::string csv_of(const nlohmann::ordered_json& rows);

/// Throws std::runtime_error when that fails.
void write_file(const std::string& file, const std::string& content);

/// The same. Names of files and machines may hold any bytes: those that are not UTF-8 are replaced.
void write_json(const std::string& file, const nlohmann::ordered_json& json);

}  // namespace softcd::benchmarks

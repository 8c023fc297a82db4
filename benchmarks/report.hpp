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

/// Returns the head of a result: the benchmark, the machine, the time and the build. An empty `machine` means the name
/// of the processor.
nlohmann::ordered_json describe_run(const std::string& benchmark, const std::string& machine);

/// A Markdown table whose columns are aligned for terminals, too: text to the left, numbers to the right.
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

/// Returns objects as comma-separated values under a line of the first one's keys, a.b for b in a. Null and absent
/// values become empty. Text must not contain quotation marks.
std::string csv_of(const nlohmann::ordered_json& rows);

/// Writes a file. Throws std::runtime_error when that fails.
void write_file(const std::string& file, const std::string& content);

/// Writes a JSON file. Throws std::runtime_error when that fails. Replaces bytes that are not UTF-8, which names of
/// files and machines may contain.
void write_json(const std::string& file, const nlohmann::ordered_json& json);

}  // namespace softcd::benchmarks

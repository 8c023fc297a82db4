#include "recorded_queries.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace softcd::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) {
    field.erase(0, field.find_first_not_of(' '));
    field.erase(field.find_last_not_of(" \r") + 1);
    fields.push_back(field);
  }
  return fields;
}

std::vector<RecordedQuery> read_queries(const fs::path& path, ContactKind kind) {
  std::ifstream file(path);
  std::vector<RecordedQuery> queries;
  std::size_t row = 0;
  for (std::string line; std::getline(file, line); ++row) {
    const std::vector<std::string> fields = split(line);
    if (fields.size() != 7) throw std::runtime_error("not 7 columns in " + path.string());
    if (row % 8 == 0) queries.push_back({kind, {}, fields[6] == "1"});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      queries.back().coordinates[3 * (row % 8) + axis] = {fields[2 * axis], fields[2 * axis + 1]};
    }
  }
  return queries;
}

}  // namespace

std::vector<RecordedQuery> read_recorded_queries(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<RecordedQuery> all;
  for (const fs::path& file : files) {
    const bool is_edge_edge = file.parent_path().filename() == "edge-edge";
    const std::vector<RecordedQuery> queries =
        read_queries(file, is_edge_edge ? ContactKind::edge_edge : ContactKind::vertex_triangle);
    all.insert(all.end(), queries.begin(), queries.end());
  }
  return all;
}

Query to_double(const RecordedQuery& recorded) {
  Query query{recorded.kind, {}};
  for (std::size_t row = 0; row < 8; ++row) {
    std::array<double, 3> p;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Fraction& fraction = recorded.coordinates[3 * row + axis];
      p[axis] = std::stod(fraction.numerator) / std::stod(fraction.denominator);
    }
    query.rows[row] = {p[0], p[1], p[2]};
  }
  return query;
}

}  // namespace softcd::test

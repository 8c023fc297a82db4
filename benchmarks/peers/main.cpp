// Tests recorded queries with softcd and with other programs: see benchmarks/peers.sh.

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "methods.hpp"
#include "recorded_queries.hpp"

namespace softcd::peers {
namespace {

namespace fs = std::filesystem;

struct Query {
  bool is_edge_edge, touches;
  std::vector<Point> x;
};

struct Result {
  int invented = 0, missed = 0;
  double microseconds = 0;
};

std::vector<Query> read(const fs::path& folder) {
  std::vector<Query> queries;
  for (const test::RecordedQuery& recorded : test::read_recorded_queries(folder)) {
    Query query{recorded.kind == ContactKind::edge_edge, recorded.collides, {}};
    for (const Vec3d& p : test::to_double(recorded).rows) query.x.emplace_back(p.x, p.y, p.z);
    queries.push_back(std::move(query));
  }
  return queries;
}

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

Result run(const Method& method, const std::vector<Query>& queries) {
  Result result;
  const double start = processor_seconds();
  for (const Query& query : queries) {
    const Test test = query.is_edge_edge ? method.edge_edge : method.vertex_face;
    const std::vector<Point>& x = query.x;
    const bool touches = test(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7]);
    if (touches && !query.touches) ++result.invented;
    if (!touches && query.touches) ++result.missed;
  }
  result.microseconds = 1e6 * (processor_seconds() - start) / static_cast<double>(queries.size());
  return result;
}

/// Returns the counts, and the least time of `rounds` in which the methods take turns.
std::vector<Result> run_all(const std::vector<Method>& methods, const std::vector<Query>& queries, int rounds) {
  std::vector<Result> least;
  for (const Method& method : methods) least.push_back(run(method, queries));
  for (int round = 1; round < rounds; ++round) {
    for (std::size_t i = 0; i < methods.size(); ++i) {
      least[i].microseconds = std::min(least[i].microseconds, run(methods[i], queries).microseconds);
    }
  }
  return least;
}

void print_row(const std::string& name, const std::vector<Query>& queries, const std::vector<Result>& results) {
  const auto touching = std::count_if(queries.begin(), queries.end(), [](const Query& query) { return query.touches; });
  std::printf("| %s | %zu | %td |", name.c_str(), queries.size(), touching);
  for (const Result& result : results) {
    std::printf(" %d, %d; %.2f |", result.invented, result.missed, result.microseconds);
  }
  std::printf("\n");
  std::fflush(stdout);
}

int compare(const fs::path& folder, int rounds) {
  const std::vector<Method> methods = {kSoftcd, kTightInclusion, kTdib};
  std::vector<fs::path> sets;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && fs::exists(entry.path() / "edge-edge")) sets.push_back(entry.path());
  }
  if (sets.empty()) throw std::runtime_error(folder.string() + ": has no folders of queries");
  std::sort(sets.begin(), sets.end());
  std::string line = "|:--|--:|--:|";
  std::printf("| set | queries | touch |");
  for (const Method& method : methods) {
    std::printf(" %s |", method.name);
    line += "--:|";
  }
  std::printf("\n%s\n", line.c_str());
  for (const fs::path& set : sets) {
    const std::vector<Query> queries = read(set);
    print_row(set.filename().string(), queries, run_all(methods, queries, rounds));
  }
  return 0;
}

}  // namespace
}  // namespace softcd::peers

int main(int argc, char** argv) {
  try {
    if (argc != 3) throw std::runtime_error("give a folder of queries, and the number of rounds");
    return softcd::peers::compare(argv[1], std::stoi(argv[2]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "peers: %s\n", error.what());
    return 1;
  }
}

#include "compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "build_runs.hpp"
#include "command_line/stage_times.hpp"
#include "report.hpp"
#include "results.hpp"

// Decides whether the detector has become slower, from the results of two builds, row by row.

namespace softcd::benchmarks {
namespace {

std::string two_decimals(double value) {
  return fmt::format("{:.2f}", value);
}

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{:.1f}", static_cast<double>(bytes) / 1e6);
}

/// Returns the relative variation of `ms.total`.
double variation(const ResultRow& row) {
  return row.ms.total > 0 ? (row.high_ms - row.low_ms) / row.ms.total : 0;
}

/// A row that both sides have.
struct Pair {
  const ResultRow& before;
  const ResultRow& after;
  double least_tolerance;

  bool is_measured() const { return before.left_out.empty() && after.left_out.empty(); }
  double ratio() const { return after.ms.total / before.ms.total; }
  double tolerance() const { return std::max({least_tolerance, variation(before), variation(after)}); }
  bool is_slower() const { return is_measured() && ratio() > 1 + tolerance(); }
  bool is_faster() const { return is_measured() && ratio() * (1 + tolerance()) < 1; }
  bool is_larger() const {
    return is_measured() &&
           static_cast<double>(after.peak_bytes) > static_cast<double>(before.peak_bytes) * (1 + least_tolerance);
  }
  bool is_lost() const { return before.left_out.empty() && !after.left_out.empty(); }
  bool has_other_contacts() const { return is_measured() && before.checksum != after.checksum; }
  bool has_other_counts() const { return is_measured() && before.counts != after.counts; }

  std::string verdict() const {
    if (is_lost()) return "NOT MEASURED: " + after.left_out;
    if (!before.left_out.empty()) return after.left_out.empty() ? "measured now" : "left out";
    std::vector<const char*> words;
    if (is_slower()) words.push_back("SLOWER");
    if (is_faster()) words.push_back("faster");
    if (is_larger()) words.push_back("MORE MEMORY");
    if (has_other_contacts()) words.push_back("other contacts");
    return words.empty() ? "same" : fmt::format("{}", fmt::join(words, ", "));
  }
};

const ResultRow* find(const Results& results, const ResultRow& wanted) {
  const auto found = std::find_if(results.rows.begin(), results.rows.end(),
                                  [&](const ResultRow& row) { return row.settings == wanted.settings; });
  return found == results.rows.end() ? nullptr : &*found;
}

std::string name_of(const ResultRow& row) {
  const auto& [scene, triangles, backend, mode, dials] = row.settings;
  return fmt::format("{} of {} triangles, {}, {}{}{}", scene, triangles, backend, mode, dials.empty() ? "" : ", ",
                     dials);
}

class Comparison {
 public:
  Comparison(const Results& before, const Results& after, double tolerance)
      : before_(before), after_(after), tolerance_(tolerance) {
    for (const ResultRow& row : before.rows) {
      if (const ResultRow* const other = find(after, row)) pairs_.push_back({row, *other, tolerance});
    }
    if (pairs_.empty()) throw std::runtime_error("there is nothing to compare: no row is in both results");
  }

  bool found_loss() const { return count(&Pair::is_slower) + count(&Pair::is_larger) + count(&Pair::is_lost) > 0; }

  void print() const {
    fmt::print("old: {}\nnew: {}\n\n{}", before_.origin, after_.origin, rows_table());
    fmt::print("\nTolerance: {:g} %, or what a row's time varied by where that is more.\n", 100 * tolerance_);
    if (count(&Pair::is_slower) > 0) fmt::print("\nStages of what is slower, milliseconds:\n\n{}", stages_table());
    print_other_results();
    print_rows_of_one(before_, after_, "old");
    print_rows_of_one(after_, before_, "new");
    print_conclusion();
  }

 private:
  std::size_t count(bool (Pair::*is)() const) const {
    return static_cast<std::size_t>(
        std::count_if(pairs_.begin(), pairs_.end(), [is](const Pair& pair) { return (pair.*is)(); }));
  }

  std::string rows_table() const {
    Table table({"scene", "triangles", "backend", "detection", "dials", "old ms", "new ms", "new/old", "tolerance",
                 "old MB", "new MB", "verdict"},
                5);
    for (const Pair& pair : pairs_) {
      std::vector<std::string> cells(pair.before.settings.begin(), pair.before.settings.end());
      if (pair.is_measured()) {
        for (const std::string& figure :
             {fmt::format("{:.3f}", pair.before.ms.total), fmt::format("{:.3f}", pair.after.ms.total),
              fmt::format("{:.3f}", pair.ratio()), fmt::format("{:.1f} %", 100 * pair.tolerance()),
              megabytes(pair.before.peak_bytes), megabytes(pair.after.peak_bytes)}) {
          cells.push_back(figure);
        }
      }
      cells.resize(11);
      cells.push_back(pair.verdict());
      table.add(cells);
    }
    return table.text();
  }

  std::string stages_table() const {
    Table table({"scene", "backend", "detection", "dials", "stage", "old ms", "new ms", "new/old"}, 5);
    for (const Pair& pair : pairs_) {
      if (!pair.is_slower()) continue;
      const auto& [scene, triangles, backend, mode, dials] = pair.before.settings;
      for (const demo::StageTime& stage : demo::kStageTimes) {
        const double old_ms = pair.before.ms.*stage.ms, new_ms = pair.after.ms.*stage.ms;
        table.add({scene, backend, mode, dials, stage.name, fmt::format("{:.3f}", old_ms),
                   fmt::format("{:.3f}", new_ms), old_ms > 0 ? two_decimals(new_ms / old_ms) : ""});
      }
    }
    return table.text();
  }

  void print_other_results() const {
    for (const Pair& pair : pairs_) {
      if (!pair.has_other_contacts() && !pair.has_other_counts()) continue;
      fmt::print("\n{}: {}", name_of(pair.before), pair.has_other_contacts() ? "OTHER CONTACTS" : "the same contacts");
      for (std::size_t i = 0; i < pair.before.counts.size(); ++i) {
        const auto& [name, old_count] = pair.before.counts[i];
        const std::uint64_t new_count = pair.after.counts[i].second;
        if (old_count != new_count) fmt::print(", {} {} -> {}", name, old_count, new_count);
      }
    }
    if (count(&Pair::has_other_contacts) + count(&Pair::has_other_counts) > 0) fmt::print("\n");
  }

  static void print_rows_of_one(const Results& with, const Results& without, const char* name) {
    for (const ResultRow& row : with.rows) {
      if (find(without, row) == nullptr) fmt::print("\nOnly in {}: {}\n", name, name_of(row));
    }
  }

  void print_conclusion() const {
    double sum = 0;
    for (const Pair& pair : pairs_) sum += pair.is_measured() ? std::log(pair.ratio()) : 0;
    const std::size_t measured = count(&Pair::is_measured);
    fmt::print(
        "\n{}: of {} rows {} slower, {} faster, {} with more memory, {} not measured any more, {} with other "
        "contacts",
        found_loss() ? "LOSS" : "no loss", pairs_.size(), count(&Pair::is_slower), count(&Pair::is_faster),
        count(&Pair::is_larger), count(&Pair::is_lost), count(&Pair::has_other_contacts));
    if (measured > 0) fmt::print("; new/old on average {:.3f}", std::exp(sum / static_cast<double>(measured)));
    fmt::print("\n");
  }

  const Results& before_;
  const Results& after_;
  double tolerance_;
  std::vector<Pair> pairs_;
};

void run(CompareOptions& options) {
  Results before, after;
  if (options.builds.first.empty()) {
    if (options.arguments.size() != 2) throw CLI::ValidationError("compare", "needs two files of results, or --builds");
    before = read_results(options.arguments[0]);
    after = read_results(options.arguments[1]);
  } else {
    std::tie(before, after) =
        run_builds(options.builds.first, options.builds.second, options.arguments, options.rounds);
  }
  const Comparison comparison(before, after, options.tolerance / 100);
  comparison.print();
  options.found_loss = comparison.found_loss();
}

}  // namespace

void add_compare(CLI::App& app, CompareOptions& options) {
  CLI::App* command = app.add_subcommand(
      "compare",
      "Tells whether the detector has become slower or needs more memory. Compares two files of `detector --json`, or\n"
      "two builds that measure in turn, row by row. A row is slower if its median time has grown by more than\n"
      "--tolerance, and by more than the distance of the quartiles of its repetitions (with --builds: of the rounds).\n"
      "Exit code 3: a row is slower, needs more memory or is no longer measured. Also reports changed contacts and\n"
      "counts");
  command
      ->add_option("arguments", options.arguments,
                   "Two files of results, old and new; with --builds, after --, the arguments of `detector`")
      ->option_text("OLD NEW | -- ARGUMENT...");
  command
      ->add_option(
          "--builds", options.builds,
          "Two builds of softcd-bench, old and new, that are run in turn instead. Use it on machines with other load")
      ->option_text("OLD NEW")
      ->check(CLI::ExistingFile);
  command->add_option("--rounds", options.rounds, "With --builds: runs of each build; more on a busy machine")
      ->option_text("N [7]")
      ->check(CLI::Range(2, 1000));
  command->add_option("--tolerance", options.tolerance, "Loss of time or memory, in per cent, that is accepted")
      ->option_text("P [5]")
      ->check(CLI::Range(0.0, 10000.0));
  command->callback([&options] { run(options); });
}

}  // namespace softcd::benchmarks

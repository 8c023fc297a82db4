#include "trade_queries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <optional>
#include <utility>

#include "command_line/stage_times.hpp"
#ifdef SOFTCD_BENCH_HAS_BULLET
#include "native_queries.hpp"
#endif
#include "query_detector.hpp"
#include "random.hpp"
#include "recorded_queries.hpp"
#include "scene_geometry.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/impact/impact.hpp"

namespace softcd::benchmarks {
namespace {

namespace fs = std::filesystem;
using test::Query;
using test::TimeBracket;

constexpr std::array kKinds = {ContactKind::vertex_triangle, ContactKind::edge_edge};
constexpr std::array kSubsteps = {1, 2, 4, 8, 16};
constexpr double kMarginInEdges = 0.1;  // the sum of both sides', as in the benchmark `detector`
constexpr double kLeastRoundSeconds = 2e-3;

struct Answer {
  bool is_hit;
  double time;  ///< NaN: unknown
};

/// Decides every query of one fixed set.
using DecideAll = std::function<void(std::vector<Answer>&)>;

struct Mode {
  std::string name;
  double margin;
  DecideAll decide_all;  ///< the measured function
  DecideAll answer_all;  ///< the judged function
};

/// Makes a function that decides all queries of a set, from one that decides a single query.
template <class Decide>
DecideAll for_all(const QuerySet& set, Decide decide) {
  return [&set, decide](std::vector<Answer>& answers) {
    for (std::size_t i = 0; i < set.queries.size(); ++i) answers[i] = decide(set.queries[i], i);
  };
}

template <class Decide>
Mode make_mode(std::string name, double margin, const QuerySet& set, Decide decide) {
  const DecideAll decide_all = for_all(set, decide);
  return {std::move(name), margin, decide_all, decide_all};
}

/// Makes a continuous mode. It is judged by the results of the public interface for double positions, and timed by its
/// narrow-phase test: most of a detection of two features is other work.
template <class Decide>
Mode make_continuous_mode(std::string name, Accuracy accuracy, const QuerySet& set, Decide decide) {
  PipelineOptions options;
  options.backend = Backend::cpu;
  options.detection = Detection::ccd;
  options.accuracy = accuracy;
  const auto detector = std::make_shared<test::QueryDetector>(set.kind, options);
  const auto answer = [detector](const Query& query, std::size_t) {
    const std::optional<Contact> contact = detector->detect(query);
    return Answer{contact.has_value(), contact ? static_cast<double>(contact->time_of_impact) : 1.0};
  };
  return {std::move(name), 0, for_all(set, decide), for_all(set, answer)};
}

template <class T>
Answer to_answer(const Impact<T>& impact) {
  return {impact.state != ImpactState::separated, static_cast<double>(impact.time)};
}

bool are_within(const Query& query, double t, float margin) {
  std::array<Vec3f, 4> p;
  for (std::size_t i = 0; i < 4; ++i) p[i] = vec3_cast<float>(lerp(query.rows[i], query.rows[i + 4], t));
  return query.kind == ContactKind::vertex_triangle
             ? closest_points_vertex_triangle(p[0], p[1], p[2], p[3]).are_within(margin)
             : closest_points_edge_edge(p[0], p[1], p[2], p[3]).are_within(margin);
}

/// Detects at the end of each substep in float.
Answer nearest_at_substeps(const Query& query, int substeps, float margin) {
  for (int step = 1; step <= substeps; ++step) {
    const double t = static_cast<double>(step) / substeps;
    if (are_within(query, t, margin)) return {true, t};
  }
  return {false, 1.0};
}

double length(Vec3d v) {
  return std::sqrt(squared_norm(v));
}

/// Returns the median length of the features' edges at the start of the step, without edges of length 0.
double median_edge_length(const QuerySet& set) {
  std::vector<double> lengths;
  const auto add = [&](Vec3d from, Vec3d to) {
    if (!(from == to)) lengths.push_back(length(to - from));
  };
  for (const Query& query : set.queries) {
    const auto& p = query.rows;
    if (set.kind == ContactKind::edge_edge) {
      add(p[0], p[1]);
      add(p[2], p[3]);
    } else {
      add(p[1], p[2]);
      add(p[2], p[3]);
      add(p[3], p[1]);
    }
  }
  return lengths.empty() ? 0.0 : demo::median(std::move(lengths));
}

std::vector<Mode> modes_for(const QuerySet& set) {
  std::vector<Mode> modes = {
      make_continuous_mode(
          "fast", Accuracy::fast, set,
          [](const Query& query, std::size_t) { return to_answer(test::impact_of<float>(query, 0.0F)); }),
      make_continuous_mode(
          "precise", Accuracy::precise, set,
          [](const Query& query, std::size_t) { return to_answer(test::impact_of<double>(query, 0.0)); }),
      make_continuous_mode("conservative", Accuracy::conservative, set,
                           [](const Query& query, std::size_t) { return to_answer(test::approach_of(query, 0.0)); })};
#ifdef SOFTCD_BENCH_HAS_BULLET
  if (set.kind == ContactKind::vertex_triangle) {
    const auto native = std::make_shared<const NativeQueries>(set.queries);
    modes.push_back(make_mode("bullet", 0, set, [native](const Query&, std::size_t i) {
      return Answer{native->touches(i), std::numeric_limits<double>::quiet_NaN()};
    }));
  }
#endif
  const double margin = kMarginInEdges * median_edge_length(set);
  for (const int substeps : kSubsteps) {
    modes.push_back(make_mode(fmt::format("dcd-{}", substeps), margin, set,
                              [substeps, reach = static_cast<float>(margin)](const Query& query, std::size_t) {
                                return nearest_at_substeps(query, substeps, reach);
                              }));
  }
  return modes;
}

/// Returns this thread's own processor time, which excludes other threads and programs.
double processor_seconds() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double seconds_of(const Mode& mode, std::vector<Answer>& answers, int count) {
  const double start = processor_seconds();
  for (int i = 0; i < count; ++i) mode.decide_all(answers);
  return processor_seconds() - start;
}

/// A mode's results and its time for a query.
struct Measured {
  std::vector<Answer> answers;
  double nanoseconds = 0;
};

/// Measures all modes: first the results to judge, then the times, in rounds of each mode in turn, so that other load
/// on the machine affects all of them. A round decides small sets several times.
std::vector<Measured> measure(const std::vector<Mode>& modes, std::size_t queries, int repetitions) {
  std::vector<Measured> measured(modes.size());
  std::vector<Answer> timed(queries);
  std::vector<int> counts;
  std::vector<std::vector<double>> seconds(modes.size());
  for (std::size_t m = 0; m < modes.size(); ++m) {
    measured[m].answers.resize(queries);
    modes[m].answer_all(measured[m].answers);
    const double once = std::max(seconds_of(modes[m], timed, 1), 1e-9);
    counts.push_back(static_cast<int>(std::ceil(kLeastRoundSeconds / once)));
  }
  for (int round = 0; round < repetitions; ++round) {
    for (std::size_t m = 0; m < modes.size(); ++m) {
      seconds[m].push_back(seconds_of(modes[m], timed, counts[m]) / counts[m]);
    }
  }
  for (std::size_t m = 0; m < modes.size(); ++m) {
    measured[m].nanoseconds = 1e9 * demo::median(std::move(seconds[m])) / static_cast<double>(queries);
  }
  return measured;
}

TimeErrors errors_of(std::vector<double> errors) {
  TimeErrors result;
  result.count = errors.size();
  if (errors.empty()) return result;
  std::sort(errors.begin(), errors.end());
  result.permille_999 = errors[(errors.size() - 1) * 999 / 1000];
  result.most = errors.back();
  result.median = demo::median(std::move(errors));
  return result;
}

QueryResult judge(const QuerySet& set, const Mode& mode, const Measured& measured,
                  const std::vector<std::optional<TimeBracket>>& truth) {
  const std::vector<Answer>& answers = measured.answers;
  QueryResult result;
  result.nanoseconds = measured.nanoseconds;
  result.set = set.name;
  result.kind = set.kind;
  result.mode = mode.name;
  result.margin = mode.margin;
  result.queries = set.queries.size();
  std::vector<double> early, late;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    result.touching += truth[i] ? 1 : 0;
    result.missed += truth[i] && !answers[i].is_hit ? 1 : 0;
    result.false_alarms += !truth[i] && answers[i].is_hit ? 1 : 0;
    if (!truth[i] || !answers[i].is_hit) continue;
    if (answers[i].time < truth[i]->lo) early.push_back(truth[i]->lo - answers[i].time);
    if (answers[i].time > truth[i]->hi) late.push_back(answers[i].time - truth[i]->hi);
  }
  result.early = errors_of(std::move(early));
  result.late = errors_of(std::move(late));
  return result;
}

QuerySet generate(const std::string& name, ContactKind kind, const std::vector<test::Family>& families,
                  std::size_t count) {
  QuerySet set{name, kind, {}};
  test::Random random(2026);
  for (std::size_t i = 0; i < count; ++i) {
    set.queries.push_back(test::make_query(random, kind, families[i % families.size()], /*is_single=*/true));
  }
  return set;
}

}  // namespace

std::vector<QuerySet> generate_queries(std::size_t count) {
  std::vector<test::Family> hard;
  for (std::uint32_t family = 0; family < test::kFamilies; ++family) {
    if (static_cast<test::Family>(family) != test::Family::random) hard.push_back(static_cast<test::Family>(family));
  }
  std::vector<QuerySet> sets;
  for (const ContactKind kind : kKinds) {
    sets.push_back(generate("random", kind, {test::Family::random}, count));
    sets.push_back(generate("adversarial", kind, hard, count));
  }
  return sets;
}

std::vector<QuerySet> read_query_sets(const fs::path& folder) {
  const std::vector<test::RecordedQuery> recorded = test::read_recorded_queries(folder);
  std::vector<QuerySet> sets;
  for (const ContactKind kind : kKinds) {
    QuerySet set{folder.filename().string(), kind, {}};
    for (const test::RecordedQuery& query : recorded) {
      if (query.kind == kind) set.queries.push_back(test::to_double(query));
    }
    if (!set.queries.empty()) sets.push_back(std::move(set));
  }
  return sets;
}

std::vector<QuerySet> queries_of_step(const std::string& name, const test::GroundTruth& truth) {
  const test::SceneGeometry geometry(truth.scene);
  std::vector<QuerySet> sets;
  for (const ContactKind kind : kKinds) {
    QuerySet set{name, kind, {}};
    for (const test::FeaturePair& pair : truth.listed) {
      if (pair.kind == kind) set.queries.push_back({kind, geometry.motion(pair)});
    }
    if (!set.queries.empty()) sets.push_back(std::move(set));
  }
  return sets;
}

std::vector<QueryResult> measure_queries(const QuerySet& set, int repetitions) {
  std::vector<std::optional<TimeBracket>> truth;
  truth.reserve(set.queries.size());
  for (const Query& query : set.queries) truth.push_back(test::first_contact(query));
  const std::vector<Mode> modes = modes_for(set);
  const std::vector<Measured> measured = measure(modes, set.queries.size(), repetitions);
  std::vector<QueryResult> results;
  for (std::size_t m = 0; m < modes.size(); ++m) results.push_back(judge(set, modes[m], measured[m], truth));
  return results;
}

}  // namespace softcd::benchmarks

#include "spatial_queries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "body_questions.hpp"
#include "detector_scenes.hpp"
#include "random.hpp"
#include "report.hpp"
#include "rival_scene.hpp"
#include "timing.hpp"

// Measures rays and nearest points on one mesh, with softcd and other libraries, and questions about bodies and shapes.
// The rays are independent of each other: from around the mesh to anywhere in its box.

namespace softcd::benchmarks {
namespace {

struct Answers {
  std::size_t hits = 0;
  double distances = 0;
};

struct Times {
  std::string name;
  std::size_t rays = 0, points = 0;                 ///< measured numbers; 0: none
  double build_ms = 0, rays_ms = 0, points_ms = 0;  ///< medians
};

class Benchmark {
 public:
  explicit Benchmark(const SpatialQueryOptions& options)
      : options_(options),
        scene_(options.step_folder.empty() ? make_cloth_on_ball(1) : read_recorded_step(options.step_folder)) {
    for (const SceneBody& body : scene_.bodies) {
      const auto first = static_cast<std::uint32_t>(x_.size());
      x_.insert(x_.end(), body.x_t1.begin(), body.x_t1.end());
      for (const Triangle& t : body.triangles) triangles_.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
    }
    make_questions();
  }

  void run() {
    for (const Backend backend : options_.backends) add(measure(backend));
    if (options_.measures_rivals) measure_rivals();
    const std::string report = fmt::format("{}: {} triangles, {} rays of which {} meet something, {} points\n\n{}\n{}",
                                           scene_.name, triangles_.size(), rays_.size(), answers_.hits, points_.size(),
                                           table_.text(), single_rays() + ask_about_bodies());
    fmt::print("{}", report);
    if (!options_.markdown_file.empty()) write_file(options_.markdown_file, report);
    if (!options_.json_file.empty()) write_json(options_.json_file, json_);
  }

 private:
  void make_questions() {
    Vec3d lo{INFINITY, INFINITY, INFINITY};
    Vec3d hi = -lo;
    for (const Vec3f& x : x_) {
      lo = {std::min(lo.x, double(x.x)), std::min(lo.y, double(x.y)), std::min(lo.z, double(x.z))};
      hi = {std::max(hi.x, double(x.x)), std::max(hi.y, double(x.y)), std::max(hi.z, double(x.z))};
    }
    const Vec3d centre = 0.5 * (lo + hi);
    const double radius = std::sqrt(squared_norm(hi - centre));
    extent_ = radius;
    test::Random random(1);
    const auto in_box = [&] {
      return Vec3d{random.uniform(lo.x, hi.x), random.uniform(lo.y, hi.y), random.uniform(lo.z, hi.z)};
    };
    for (std::size_t i = 0; i < options_.questions; ++i) {
      const Vec3d from = centre + radius * random.direction();
      rays_.push_back(segment(from, from + 2.0 * (in_box() - from)));
      points_.push_back({in_box()});
    }
  }

  Times measure(Backend backend) {
    SceneOptions scene_options;
    scene_options.backend = backend;
    Scene scene(scene_options);
    const BodyId body = scene.add_body({triangles_, static_cast<std::uint32_t>(x_.size()), {}});
    Probe probe(scene);
    std::vector<double> build, rays, points;
    for (int i = 0; i <= options_.repetitions; ++i) {
      scene.set_positions(body, x_);
      build.push_back(milliseconds_of([&] { probe.first_hit(rays_[0]); }));
      Span<const RayHit> hits;
      rays.push_back(milliseconds_of([&] { hits = probe.first_hits(rays_); }));
      answers_.hits = static_cast<std::size_t>(
          std::count_if(hits.begin(), hits.end(), [](const RayHit& hit) { return hit.has_hit(); }));
      Span<const ClosestPoint> closest;
      points.push_back(milliseconds_of([&] { closest = probe.closest_points(points_); }));
      answers_.distances = 0;
      for (const ClosestPoint& point : closest) answers_.distances += point.distance;
    }
    return {fmt::format("softcd, {}", demo::name_of(scene.backend())),
            rays_.size(),
            points_.size(),
            median_without_first(build),
            median_without_first(rays),
            median_without_first(points)};
  }

  void measure_rivals() {
#ifdef SOFTCD_BENCH_HAS_BULLET
    measure_rival(*make_bullet_scene(triangles_, x_));
#endif
#ifdef SOFTCD_BENCH_HAS_EMBREE
    measure_rival(*make_embree_scene(triangles_, x_));
#endif
  }

  void measure_rival(RivalScene& rival) {
    std::vector<double> build, rays, points;
    Answers answers;
    for (int i = 0; i <= options_.repetitions; ++i) {
      build.push_back(milliseconds_of([&] { rival.build(); }));
      rays.push_back(milliseconds_of([&] { answers.hits = rival.count_hits(rays_); }));
      points.push_back(milliseconds_of([&] { answers.distances = rival.sum_distances(points_); }));
    }
    const bool tells_distances = answers.distances >= 0;
    if (rival.counts_exactly()) expect_near(rival.name(), "hits", double(answers.hits), double(answers_.hits));
    if (tells_distances) expect_near(rival.name(), "distances", answers.distances, answers_.distances);
    add({rival.name(), rays_.size(), tells_distances ? points_.size() : 0, median_without_first(build),
         median_without_first(rays), median_without_first(points)});
  }

  /// Measures rays one at a time, as callers of Bullet's worlds send them.
  std::string single_rays() {
    std::string text;
#ifdef SOFTCD_BENCH_HAS_BULLET
    if (!options_.measures_rivals) return text;
    Table table({"world", "margin", "rays", "hits", "first ray us", "next rays us", "rays of batches us", "their hits"},
                1);
    for (const SingleRayTime& time : time_single_rays(std::max(options_.repetitions, 30))) {
      table.add({time.world, fmt::format("{:.2f}", time.margin), fmt::to_string(time.rays), fmt::to_string(time.hits),
                 fmt::format("{:.1f}", time.first_us), fmt::format("{:.2f}", time.next_us),
                 fmt::format("{:.2f}", time.batch_us), fmt::to_string(time.batch_hits)});
      json_["single_rays"].push_back({{"world", time.world},
                                      {"margin", time.margin},
                                      {"rays", time.rays},
                                      {"hits", time.hits},
                                      {"first_us", time.first_us},
                                      {"next_us", time.next_us},
                                      {"batch_us", time.batch_us}});
    }
    text = fmt::format(
        "Rays in a world with three cloths of 400 nodes, after each step: rayTest, and batches of WorldProbe\n\n{}\n",
        table.text());
#endif
    return text;
  }

  /// Measures questions about bodies, too.
  std::string ask_about_bodies() {
    BodyQuestions questions({triangles_, x_}, extent_, options_.questions);
    std::vector<BodyQuestionTime> times;
    const auto append = [&](const std::vector<BodyQuestionTime>& more) {
      times.insert(times.end(), more.begin(), more.end());
    };
    for (const Backend backend : options_.backends) append(questions.measure(backend, options_.repetitions));
    if (options_.measures_rivals) append(questions.measure_rivals(options_.repetitions));
    std::stable_sort(times.begin(), times.end(),
                     [](const BodyQuestionTime& a, const BodyQuestionTime& b) { return a.question < b.question; });
    Table table({"", "by", "questions", "answers", "us a question"}, 2);
    for (const BodyQuestionTime& time : times) {
      const char* const question = kBodyQuestionNames[static_cast<std::size_t>(time.question)];
      table.add({question, time.name, fmt::to_string(time.questions), fmt::to_string(time.answers),
                 fmt::format("{:.1f}", time.microseconds_each)});
      json_["bodies"].push_back({{"scene", scene_.name},
                                 {"question", question},
                                 {"name", time.name},
                                 {"questions", time.questions},
                                 {"answers", time.answers},
                                 {"us_each", time.microseconds_each}});
    }
    return fmt::format("{}\n\n{}", questions.description(), table.text());
  }

  /// Throws unless two results agree.
  static void expect_near(const char* rival, const char* what, double theirs, double ours) {
    if (std::abs(theirs - ours) <= 1e-3 * ours) return;
    throw std::runtime_error(fmt::format("{} has other results: {} {} instead of {}", rival, theirs, what, ours));
  }

  void add(const Times& times) {
    const auto ms = [](std::size_t questions, double value) {
      return questions == 0 ? std::string("-") : fmt::format("{:.1f}", value);
    };
    table_.add({times.name, ms(1, times.build_ms), ms(times.rays, times.rays_ms), ms(times.points, times.points_ms)});
    json_["rows"].push_back(
        {{"scene", scene_.name},
         {"triangles", triangles_.size()},
         {"name", times.name},
         {"rays", times.rays},
         {"points", times.points},
         {"ms", {{"build", times.build_ms}, {"rays", times.rays_ms}, {"points", times.points_ms}}}});
  }

  const SpatialQueryOptions& options_;
  DetectorScene scene_;
  std::vector<Triangle> triangles_;
  std::vector<Vec3f> x_;
  std::vector<Ray> rays_;
  std::vector<ProbePoint> points_;
  double extent_ = 0;  ///< half the diagonal of the mesh's box
  Answers answers_;
  Table table_{{"", "build ms", "rays ms", "points ms"}, 1};
  nlohmann::ordered_json json_ = describe_run("queries", options_.machine);
};

}  // namespace

void add_spatial_queries(CLI::App& app, SpatialQueryOptions& options) {
  CLI::App* command = app.add_subcommand(
      "queries",
      "Measures questions about a mesh at the end of a step. The first table has rays, to the first hit, and nearest\n"
      "points: with softcd's Probe, with Bullet's btSoftBody::rayTest and, if this build has it, with Embree 3. "
      "Median\n"
      "times in milliseconds; build is the time of the first question after positions have changed.\n\n"
      "The second table has rays among three cloths in Bullet's world and in softcd's, in microseconds: one at a time\n"
      "by rayTest, and in batches by a WorldProbe.\n\n"
      "The third table has other questions, in microseconds each, compared with other tests:\n"
      "- distances and intersections of the mesh and balls near it: a test of all pairs of triangles, for a few "
      "balls;\n"
      "- self-intersections of the mesh;\n"
      "- triangles in capsules and convex hulls: Bullet's contactPairTest of a triangle mesh (in float, one thread);\n"
      "- intersections that changes of the mesh would make: a test of every triangle.\n"
      "Tests of all triangles must give the same results; Bullet's may count a few other triangles");
  command
      ->add_option(
          "--step", options.step_folder,
          "A folder that contains a folder frames with two meshes. Default: a generated cloth on a ball, 92K triangles")
      ->option_text("DIR")
      ->check(CLI::ExistingDirectory);
  demo::add_choices(*command, "--backend", options.backends, "The backends to measure, one after the other");
  command
      ->add_option(
          "--questions", options.questions,
          "Number of rays, and of points. Capsules, hulls and changes are a hundredth of it, balls a ten-thousandth")
      ->option_text("N [1e6]")
      ->check(CLI::Range(1, 100000000));
  command->add_option("--repeat", options.repetitions, "Measured times, after one to warm up")
      ->option_text("N [5]")
      ->check(CLI::Range(1, 1000));
  command->add_flag("!--no-rivals", options.measures_rivals, "Measure softcd alone");
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the table as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure; milliseconds")->option_text("FILE");
  command->callback([&options] { Benchmark(options).run(); });
}

}  // namespace softcd::benchmarks

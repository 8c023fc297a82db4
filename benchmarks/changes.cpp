#include "changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <numeric>

#include "command_line/choices.hpp"
#include "detector_scenes.hpp"
#include "random.hpp"
#include "report.hpp"

// Measures the time to change some triangles of a body, and the time to replace all of them, until a detection could
// begin. The detection itself has nothing to do without positions.

namespace softcd::benchmarks {
namespace {

struct ChangedMesh {
  std::vector<Triangle> triangles;
  std::vector<Vec3f> x;
  std::vector<std::uint32_t> changed;
};

using MakeChange = void (*)(ChangedMesh& mesh, std::size_t count, test::Random& random);

/// Gives one corner of random triangles a vertex of its own.
void tear(ChangedMesh& mesh, std::size_t count, test::Random& random) {
  for (; count > 0; --count) {
    const std::uint32_t t = random.below(static_cast<std::uint32_t>(mesh.triangles.size()));
    std::uint32_t& corner = mesh.triangles[t].v[random.below(3)];
    mesh.x.push_back(mesh.x[corner]);
    corner = static_cast<std::uint32_t>(mesh.x.size()) - 1;
    mesh.changed.push_back(t);
  }
}

/// Splits each triangle around a place in three.
void refine(ChangedMesh& mesh, std::size_t count, test::Random& random) {
  const auto all = static_cast<std::uint32_t>(mesh.triangles.size());
  const auto centre = [&](std::uint32_t t) {
    const auto [a, b, c] = mesh.triangles[t].v;
    return (1.0F / 3.0F) * (mesh.x[a] + mesh.x[b] + mesh.x[c]);
  };
  const Vec3f place = centre(random.below(all));
  std::vector<std::uint32_t> nearest(all);
  std::iota(nearest.begin(), nearest.end(), 0U);
  const auto end = nearest.begin() + static_cast<std::ptrdiff_t>(count / 3);
  std::nth_element(nearest.begin(), end, nearest.end(), [&](std::uint32_t a, std::uint32_t b) {
    return squared_norm(centre(a) - place) < squared_norm(centre(b) - place);
  });
  mesh.changed.assign(nearest.begin(), end);
  for (const std::uint32_t t : mesh.changed) {
    const auto [a, b, c] = mesh.triangles[t].v;
    const auto middle = static_cast<std::uint32_t>(mesh.x.size());
    mesh.x.push_back(centre(t));
    mesh.triangles[t] = {{a, b, middle}};
    mesh.triangles.push_back({{b, c, middle}});
    mesh.triangles.push_back({{c, a, middle}});
  }
}

/// A scene of one body.
class MeasuredScene {
 public:
  MeasuredScene(Backend backend, const ChangedMesh& mesh, bool self_collision)
      : scene_(options_for(backend)), query_(scene_) {
    settings_.self_collision = self_collision;
    settings_.features.edge_edge = true;
    body_ = scene_.add_body(desc_of(mesh));
    scene_.set_positions(body_, mesh.x);
    query_.detect();
  }

  double milliseconds_of_all(const ChangedMesh& mesh) {
    return milliseconds_of(mesh, [&] { scene_.update_body(body_, desc_of(mesh)); });
  }
  double milliseconds_of_changed(const ChangedMesh& mesh) {
    return milliseconds_of(mesh, [&] { scene_.update_body(body_, desc_of(mesh), mesh.changed); });
  }

 private:
  static SceneOptions options_for(Backend backend) {
    SceneOptions options;
    options.backend = backend;
    return options;
  }
  BodyDesc desc_of(const ChangedMesh& mesh) const {
    return {mesh.triangles, static_cast<std::uint32_t>(mesh.x.size()), settings_};
  }
  /// Updates the mesh, then detects, so that copies elsewhere are up to date.
  template <class Update>
  double milliseconds_of(const ChangedMesh& mesh, const Update& update) {
    const auto begin = std::chrono::steady_clock::now();
    update();
    query_.detect();
    const auto end = std::chrono::steady_clock::now();
    scene_.set_positions(body_, mesh.x);
    query_.detect();
    return std::chrono::duration<double, std::milli>(end - begin).count();
  }

  BodySettings settings_;
  softcd::Scene scene_;
  Query query_;
  BodyId body_;
};

struct NamedChange {
  const char* name;
  MakeChange make;
};
constexpr NamedChange kChanges[] = {{"torn anywhere", tear}, {"refined at a place", refine}};

class Changes {
 public:
  explicit Changes(const ChangesOptions& options) : options_(options) {
    for (const SceneBody& body : make_cloth_on_ball(1).bodies) {
      const auto first = static_cast<std::uint32_t>(mesh_.x.size());
      mesh_.x.insert(mesh_.x.end(), body.x_t1.begin(), body.x_t1.end());
      for (const Triangle& t : body.triangles) {
        mesh_.triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
      }
    }
  }

  void run() {
    for (const Backend backend : options_.backends) {
      for (const NamedChange& change : kChanges) {
        for (const bool self_collision : {false, true}) measure(backend, change, self_collision);
      }
    }
    const std::string report = fmt::format("{} triangles, of which {:.2g} % change:\n\n{}", mesh_.triangles.size(),
                                           100 * options_.share, table_.text());
    fmt::print("{}", report);
    if (!options_.markdown_file.empty()) write_file(options_.markdown_file, report);
    if (!options_.json_file.empty()) write_json(options_.json_file, json_);
  }

 private:
  void measure(Backend backend, const NamedChange& change, bool self_collision) {
    ChangedMesh mesh = mesh_;
    MeasuredScene anew(backend, mesh, self_collision);
    MeasuredScene bit_by_bit(backend, mesh, self_collision);
    test::Random random(1);
    std::vector<double> all, changed, ratios;
    for (int i = 0; i <= options_.repetitions; ++i) {
      mesh.changed.clear();
      const double count = options_.share * static_cast<double>(mesh.triangles.size());
      change.make(mesh, static_cast<std::size_t>(count), random);
      const double ms_all = anew.milliseconds_of_all(mesh);
      const double ms_changed = bit_by_bit.milliseconds_of_changed(mesh);
      if (i == 0) continue;  // the first prepares the body
      all.push_back(ms_all);
      changed.push_back(ms_changed);
      ratios.push_back(ms_changed / ms_all);
    }
    add(backend, change.name, self_collision, {median(all), median(changed), median(ratios)});
  }

  struct Row {
    double all_ms, changed_ms, ratio;
  };

  static double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
  }

  void add(Backend backend, const char* change, bool self_collision, const Row& row) {
    const std::string where = demo::name_of(backend);
    table_.add({where, change, self_collision ? "yes" : "no", fmt::format("{:.2f}", row.all_ms),
                fmt::format("{:.2f}", row.changed_ms), fmt::format("{:.3f}", row.ratio)});
    json_["rows"].push_back({{"backend", where},
                             {"change", change},
                             {"self_collision", self_collision},
                             {"ms", {{"all", row.all_ms}, {"changed", row.changed_ms}}},
                             {"ratio", row.ratio}});
  }

  const ChangesOptions& options_;
  ChangedMesh mesh_;
  Table table_{{"", "triangles", "touches itself", "all ms", "changed ms", "ratio"}, 3};
  nlohmann::ordered_json json_ = describe_run("changes", options_.machine);
};

}  // namespace

void add_changes(CLI::App& app, ChangesOptions& options) {
  CLI::App* command = app.add_subcommand(
      "changes",
      "Measures changes of a mesh, a cloth on a ball of 92K triangles: Scene::update_body gets all triangles or the\n"
      "changed ones alone, in turn. The time ends when a detection could begin. Median milliseconds, and the median\n"
      "of their ratios");
  demo::add_choices(*command, "--backend", options.backends, "The backends to measure, one after the other");
  command->add_option("--share", options.share, "Share of the triangles that a change replaces or adds")
      ->option_text("SHARE [0.01]")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--repeat", options.repetitions, "Measured changes, after one that prepares the body")
      ->option_text("N [15]")
      ->check(CLI::Range(1, 1000));
  command->add_option("--machine", options.machine, "The machine's name in the results. Default: its processor")
      ->option_text("TEXT");
  command->add_option("--markdown", options.markdown_file, "Write the table as Markdown")->option_text("FILE");
  command->add_option("--json", options.json_file, "Write every figure; milliseconds")->option_text("FILE");
  command->callback([&options] { Changes(options).run(); });
}

}  // namespace softcd::benchmarks

#include "trade_steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "command_line/stage_times.hpp"
#include "detector_measurement.hpp"
#include "queries.hpp"
#include "scene_geometry.hpp"

namespace softcd::benchmarks {
namespace {

using test::FeaturePair;
using Pairs = std::vector<FeaturePair>;  // sorted, each once
using Clock = std::chrono::steady_clock;

struct Mode {
  std::string name;
  Detection detection;
  Accuracy accuracy;
  int substeps;
};

const std::vector<Mode>& modes() {
  static const std::vector<Mode> list = [] {
    std::vector<Mode> all = {{"fast", Detection::ccd, Accuracy::fast, 1},
                             {"precise", Detection::ccd, Accuracy::precise, 1},
                             {"conservative", Detection::ccd, Accuracy::conservative, 1}};
    for (const int substeps : {1, 2, 4, 8, 16}) {
      all.push_back({fmt::format("dcd-{}", substeps), Detection::dcd, Accuracy::fast, substeps});
    }
    return all;
  }();
  return list;
}

void sort_unique(Pairs& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

std::size_t count_without(const Pairs& a, const Pairs& b) {
  Pairs rest;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(rest));
  return rest.size();
}

test::Scene to_test_scene(const DetectorScene& scene) {
  test::Scene bodies;
  const auto to_doubles = [](const std::vector<Vec3f>& x) {
    test::Positions3 wide(x.size());
    std::transform(x.begin(), x.end(), wide.begin(), [](Vec3f p) { return vec3_cast<double>(p); });
    return wide;
  };
  for (const SceneBody& body : scene.bodies) {
    bodies.push_back({body.triangles, to_doubles(body.x_t0), to_doubles(body.x_t1), body.settings});
  }
  return bodies;
}

/// Runs one mode on one scene.
class Detector {
 public:
  Detector(const DetectorScene& scene, const Mode& mode, bool has_edges, Backend backend)
      : scene_(scene), mode_(mode), pipeline_(options_of(mode, backend)) {
    for (const SceneBody& body : scene.bodies) {
      BodySettings settings = body.settings;
      settings.features = {/*vertex_triangle=*/true, has_edges};
      if (is_discrete()) settings.margin = static_cast<float>(kMarginInEdges * scene.edge_length);
      ids_.push_back(
          pipeline_.scene.add_body({body.triangles, static_cast<std::uint32_t>(body.x_t0.size()), settings}));
    }
    for (int step = 1; step <= mode.substeps && is_discrete(); ++step) {
      positions_.push_back(positions_at(static_cast<float>(step) / static_cast<float>(mode.substeps)));
    }
  }

  bool is_discrete() const { return mode_.detection == Detection::dcd; }
  CollisionPipeline& pipeline() { return pipeline_; }

  /// Detects at every substep. Returns the sum of their times.
  template <class Visit>
  StageTimes run(const Visit& visit) {
    StageTimes sum;
    for (int step = 0; step < mode_.substeps; ++step) {
      for (std::size_t b = 0; b < ids_.size(); ++b) {
        const SceneBody& body = scene_.bodies[b];
        if (is_discrete()) {
          pipeline_.scene.set_positions(ids_[b], positions_[static_cast<std::size_t>(step)][b]);
        } else {
          pipeline_.scene.set_positions(ids_[b], body.x_t0, body.x_t1);
        }
      }
      visit(pipeline_.detect());
      for (const demo::StageTime& stage : demo::kStageTimes) sum.*stage.ms += pipeline_.query.statistics().ms.*stage.ms;
    }
    return sum;
  }

 private:
  using BodyPositions = std::vector<std::vector<Vec3f>>;

  static PipelineOptions options_of(const Mode& mode, Backend backend) {
    PipelineOptions options;
    options.backend = backend;
    options.detection = mode.detection;
    options.accuracy = mode.accuracy;
    options.reuse_pairs = false;  // all repetitions have the same positions
    return options;
  }

  BodyPositions positions_at(float t) const {
    BodyPositions positions;
    for (const SceneBody& body : scene_.bodies) {
      std::vector<Vec3f> x(body.x_t0.size());
      for (std::size_t v = 0; v < x.size(); ++v) x[v] = (1.0F - t) * body.x_t0[v] + t * body.x_t1[v];
      positions.push_back(std::move(x));
    }
    return positions;
  }

  const DetectorScene& scene_;
  const Mode& mode_;
  CollisionPipeline pipeline_;
  std::vector<BodyId> ids_;
  std::vector<BodyPositions> positions_;  ///< of discrete modes, at the end of each substep
};

struct Measured {
  StepResult result;
  Pairs reported;
};

StepResult describe(const DetectorScene& scene, const Mode& mode, bool has_edges, Detector& detector) {
  StepResult result;
  result.scene = scene.name;
  result.has_edges = has_edges;
  result.mode = mode.name;
  result.backend = detector.pipeline().scene.backend();
  result.triangles = scene.triangle_count();
  result.margin = detector.is_discrete() ? 2 * kMarginInEdges * scene.edge_length : 0;
  result.unsettled = detector.pipeline().query.statistics().unsettled_contacts;
  return result;
}

/// Measures a step of each mode in turn, so that other load on the machine affects all of them.
std::vector<Measured> measure(const DetectorScene& scene, bool has_edges, Backend backend, int repetitions) {
  std::vector<Measured> all;
  std::vector<std::unique_ptr<Detector>> detectors;
  for (const Mode& mode : modes()) {
    detectors.push_back(std::make_unique<Detector>(scene, mode, has_edges, backend));
    Pairs reported;
    detectors.back()->run([&](Span<const Contact> contacts) {
      const Pairs pairs = test::features_of(contacts);
      reported.insert(reported.end(), pairs.begin(), pairs.end());
    });
    sort_unique(reported);
    all.push_back({describe(scene, mode, has_edges, *detectors.back()), std::move(reported)});
  }
  std::vector<std::vector<StageTimes>> times(detectors.size());
  const Clock::time_point start = Clock::now();
  do {
    for (std::size_t m = 0; m < detectors.size(); ++m) {
      times[m].push_back(detectors[m]->run([](Span<const Contact>) {}));
    }
  } while (static_cast<int>(times.front().size()) < repetitions &&
           std::chrono::duration<double>(Clock::now() - start).count() < kMostSeconds);
  for (std::size_t m = 0; m < detectors.size(); ++m) {
    const StageTimes median = demo::median(times[m]);
    all[m].result.ms = median.total - median.transfer;
    all[m].result.transfer_ms = median.transfer;
  }
  return all;
}

}  // namespace

StepScene to_step_scene(const std::string& name, const test::GroundTruth& truth) {
  StepScene step{{name, 0, {}}, truth.listed};
  double sum = 0;
  std::size_t count = 0;
  const auto to_floats = [](const test::Positions3& x) {
    std::vector<Vec3f> narrow(x.size());
    std::transform(x.begin(), x.end(), narrow.begin(), [](Vec3d p) { return vec3_cast<float>(p); });
    return narrow;
  };
  for (const test::SceneBody& body : truth.scene) {
    for (const Edge& edge : test::edges_of(body.triangles)) {
      sum += std::sqrt(squared_norm(body.x_t0[edge.v[1]] - body.x_t0[edge.v[0]]));
      ++count;
    }
    step.scene.bodies.push_back({body.triangles, to_floats(body.x_t0), to_floats(body.x_t1), body.settings});
  }
  step.scene.edge_length = sum / static_cast<double>(count);
  return step;
}

std::vector<StepResult> measure_steps(const StepScene& step, const std::vector<Backend>& backends, int repetitions) {
  const test::Scene exact_scene = to_test_scene(step.scene);
  const test::SceneGeometry geometry(exact_scene);
  const auto touches = [&](const FeaturePair& pair) { return test::collides({pair.kind, geometry.motion(pair)}); };
  std::vector<StepResult> results;
  for (const Backend backend : backends) {
    for (const bool has_edges : {false, true}) {
      std::vector<Measured> all = measure(step.scene, has_edges, backend, repetitions);
      Pairs candidates;
      for (const FeaturePair& pair : step.listed) {
        if (has_edges || pair.kind == ContactKind::vertex_triangle) candidates.push_back(pair);
      }
      for (const Measured& measured : all) {
        candidates.insert(candidates.end(), measured.reported.begin(), measured.reported.end());
      }
      sort_unique(candidates);
      Pairs touching;
      std::copy_if(candidates.begin(), candidates.end(), std::back_inserter(touching), touches);
      for (Measured& measured : all) {
        measured.result.is_listed = !step.listed.empty();
        measured.result.contacts = measured.reported.size();
        measured.result.touching = touching.size();
        measured.result.missed = count_without(touching, measured.reported);
        measured.result.extra = count_without(measured.reported, touching);
        results.push_back(measured.result);
      }
    }
  }
  return results;
}

}  // namespace softcd::benchmarks

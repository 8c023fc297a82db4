#include "certifier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>

#include "exact_motion.hpp"
#include "frame_intersections.hpp"

namespace softcd::demo {
namespace {

/// The number of reported pairs of a step for which a proof of a crossing is tried, if fewer are listed.
constexpr std::size_t kLeastProofs = 100;

/// Returns the least float that is not below `margin`.
float rounded_up(double margin) {
  const auto nearest = static_cast<float>(margin);
  if (static_cast<double>(nearest) >= margin) return nearest;
  return std::nextafter(nearest, std::numeric_limits<float>::infinity());
}

template <class Pair>
PairList<Pair> start_of(std::vector<Pair> pairs, std::size_t most) {
  const std::size_t count = pairs.size();
  pairs.resize(std::min(count, most));
  return {count, std::move(pairs)};
}

bool has_same_features(const ReportedPair& a, const ReportedPair& b) {
  return a.kind == b.kind && a.mesh_a == b.mesh_a && a.mesh_b == b.mesh_b && a.vertices == b.vertices;
}

/// Appends those of `pairs` that pass through each other and are not in `others`. Both lists are in ascending order.
void append_through(const std::vector<TrianglePair>& pairs, const std::vector<TrianglePair>& others,
                    std::vector<TrianglePair>& found) {
  for (const TrianglePair& pair : pairs) {
    if (pair.is_through && !std::binary_search(others.begin(), others.end(), pair)) found.push_back(pair);
  }
}

class Certifier {
 public:
  Certifier(const CertifyOptions& options, const SceneOptions& scene, std::vector<MeshSequence> meshes,
            const LogCallback& log)
      : options_(options),
        meshes_(std::move(meshes)),
        scene_(scene, log),
        bodies_(add_bodies()),
        query_(scene_, query_options(true)),
        touching_(scene_, query_options(false)),
        intersections_(scene_, bodies_) {}

  Certificate run(const std::function<void(const std::string&)>& show) {
    Certificate certificate;
    certificate.options = options_;
    const std::size_t frame_count = meshes_[0].size();
    show(fmt::format("frame 1 of {}", frame_count));
    std::vector<TrianglePair> before = read_frame_and_find();
    certificate.frames.push_back(start_of(before, options_.list));
    for (std::size_t frame = 1; frame < frame_count; ++frame) {
      show(fmt::format("frame {} of {}", frame + 1, frame_count));
      for (MeshSequence& mesh : meshes_) {
        if (mesh.is_moving()) mesh.read_next();
      }
      set_positions();
      StepResult step = compare_path();
      std::vector<TrianglePair> after = intersections_.find(meshes_);
      judge(before, after, step);
      certificate.steps.push_back(std::move(step));
      certificate.frames.push_back(start_of(after, options_.list));
      before = std::move(after);
    }
    for (const MeshSequence& mesh : meshes_) certificate.meshes.push_back(summary_of(mesh));
    return certificate;
  }

 private:
  static QueryOptions query_options(bool margins) {
    QueryOptions options;
    options.margins = margins;
    options.detection = Detection::ccd;
    options.accuracy = Accuracy::conservative;
    return options;
  }

  /// Reads the first frames: their triangles are the bodies'.
  std::vector<BodyId> add_bodies() {
    std::vector<BodyId> bodies;
    for (MeshSequence& mesh : meshes_) {
      mesh.read_next();
      BodySettings settings;
      settings.margin = rounded_up(options_.margin);
      settings.kinematic = !bodies.empty();  // further meshes are not compared with each other
      const auto vertex_count = static_cast<std::uint32_t>(mesh.current().positions.size());
      bodies.push_back(scene_.add_body({mesh.current().triangles, vertex_count, settings}));
    }
    return bodies;
  }

  std::vector<TrianglePair> read_frame_and_find() {
    for (std::size_t i = 0; i < meshes_.size(); ++i) scene_.set_positions(bodies_[i], meshes_[i].current().positions);
    return intersections_.find(meshes_);
  }

  void set_positions() {
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
      if (meshes_[i].is_moving()) {
        scene_.set_positions(bodies_[i], meshes_[i].previous().positions, meshes_[i].current().positions);
      }
    }
  }

  std::uint32_t mesh_of(BodyId body) const {
    return static_cast<std::uint32_t>(std::find(bodies_.begin(), bodies_.end(), body) - bodies_.begin());
  }

  /// Finds the features that touch on their paths, or come within the margins.
  StepResult compare_path() {
    std::vector<ReportedPair> pairs = detect(query_);
    std::vector<ReportedPair> crossing = pairs;
    if (options_.margin > 0 && !pairs.empty()) crossing = detect(touching_);
    crossing.resize(std::min(crossing.size(), std::max<std::size_t>(options_.list, kLeastProofs)));
    std::erase_if(crossing, [this](const ReportedPair& pair) { return !passes_through(pair); });

    StepResult step;
    if (!pairs.empty()) step.verdict = crossing.empty() ? Verdict::not_proved : Verdict::crossed;
    for (ReportedPair& pair : pairs) {
      pair.passes_through = std::any_of(crossing.begin(), crossing.end(),
                                        [&](const ReportedPair& other) { return has_same_features(pair, other); });
    }
    std::stable_partition(pairs.begin(), pairs.end(), [](const ReportedPair& pair) { return pair.passes_through; });
    step.pairs = start_of(std::move(pairs), options_.list);
    return step;
  }

  /// Returns the reported pairs, the earliest first; pairs of the same time in the order of features.
  std::vector<ReportedPair> detect(Query& query) const {
    const Span<const Contact> contacts = query.detect();
    if (query.statistics().left_out_triangles > 0) throw std::runtime_error("triangles were left out of a step");
    std::vector<ReportedPair> pairs;
    pairs.reserve(contacts.size());
    for (const Contact& contact : contacts) {
      const auto& v = contact.vertices;
      pairs.push_back({contact.kind,
                       mesh_of(contact.body_a),
                       mesh_of(contact.body_b),
                       {v[0], v[1], v[2], v[3]},
                       contact.time_of_impact,
                       false});
    }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const ReportedPair& a, const ReportedPair& b) { return a.time < b.time; });
    return pairs;
  }

  bool passes_through(const ReportedPair& pair) const {
    PairPositions x_t0{};
    PairPositions x_t1{};
    const std::size_t count_of_a = pair.kind == ContactKind::vertex_triangle ? 1 : 2;
    for (std::size_t i = 0; i < 4; ++i) {
      const MeshSequence& mesh = meshes_[i < count_of_a ? pair.mesh_a : pair.mesh_b];
      x_t0[i] = mesh.previous().positions[pair.vertices[i]];
      x_t1[i] = mesh.current().positions[pair.vertices[i]];
    }
    return certainly_pass_through(pair.kind, x_t0, x_t1, static_cast<double>(pair.time));
  }

  /// Compares the triangles that intersect at both ends of the step. Where they differ, features must have touched.
  void judge(const std::vector<TrianglePair>& before, const std::vector<TrianglePair>& after, StepResult& step) const {
    std::vector<TrianglePair> changed;
    append_through(before, after, changed);
    append_through(after, before, changed);
    std::sort(changed.begin(), changed.end());
    if (step.pairs.count == 0 && !changed.empty()) {
      throw std::runtime_error(fmt::format(
          "the detection of a step missed a crossing of triangles {} and {} that exact arithmetic shows; please report "
          "this defect of softcd, with the frames",
          changed[0].triangle_a, changed[0].triangle_b));
    }
    if (!changed.empty()) step.verdict = Verdict::crossed;
    step.changed = start_of(std::move(changed), options_.list);
  }

  static CertifiedMesh summary_of(const MeshSequence& mesh) {
    CertifiedMesh summary;
    summary.vertices = mesh.current().positions.size();
    summary.triangles = mesh.current().triangles.size();
    for (std::size_t i = 0; i < mesh.size(); ++i) summary.names.push_back(mesh.file(i).filename().string());
    summary.hashes = mesh.hashes();
    return summary;
  }

  CertifyOptions options_;
  std::vector<MeshSequence> meshes_;
  Scene scene_;
  std::vector<BodyId> bodies_;
  Query query_;
  Query touching_;  ///< without margins
  FrameIntersections intersections_;
};

}  // namespace

Certificate certify(const CertifyOptions& options, const SceneOptions& scene, std::vector<MeshSequence> meshes,
                    const std::function<void(const std::string&)>& show, const LogCallback& log) {
  return Certifier(options, scene, std::move(meshes), log).run(show);
}

}  // namespace softcd::demo

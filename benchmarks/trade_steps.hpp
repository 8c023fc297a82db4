#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "detector_scenes.hpp"
#include "ground_truth.hpp"
#include "softcd/softcd.hpp"

// Judges whole steps of the detector: which of the contacts that exact arithmetic confirms each mode reports.

namespace softcd::benchmarks {

struct StepScene {
  DetectorScene scene;
  /// Pairs that may touch, in addition to those that a mode reports.
  std::vector<test::FeaturePair> listed;
};

StepScene to_step_scene(const std::string& name, const test::GroundTruth& truth);

struct StepResult {
  std::string scene;
  bool has_edges;  ///< edge-edge contacts too
  std::string mode;
  Backend backend;
  std::size_t triangles = 0;
  double margin = 0;          ///< the sum of both sides', of discrete modes
  bool is_listed = false;     ///< the scene came with a list of pairs
  std::size_t touching = 0;   ///< in exact arithmetic
  std::size_t contacts = 0;   ///< reported, each pair once whatever the number of substeps
  std::size_t missed = 0;     ///< touching, not reported
  std::size_t extra = 0;      ///< reported, not touching
  std::size_t unsettled = 0;  ///< reported because the bound on work was reached
  double ms = 0;              ///< of all substeps, without `transfer_ms`
  double transfer_ms = 0;
};

/// One result for each mode, features and backend. Times are medians.
std::vector<StepResult> measure_steps(const StepScene& scene, const std::vector<Backend>& backends, int repetitions);

}  // namespace softcd::benchmarks

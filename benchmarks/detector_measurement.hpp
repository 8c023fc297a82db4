#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "detector_scenes.hpp"
#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

/// What is measured.
struct MeasuredOptions : PipelineOptions {
  /// What is measured is a detection on its own, though repetitions look where the ones before them did.
  MeasuredOptions() { reuse_pairs = false; }

  bool on_device = false;  ///< positions and contacts are in the device's memory
  bool rocks = false;      ///< every other detection is of the step backwards
  bool is_paper = false;   ///< the broad phase is the printed one (paper/scheme.hpp), instead of `broad_phase`
};

/// What one detector costs on one scene.
struct Measurement {
  std::string scene;
  MeasuredOptions options;                              ///< with the backend that was used, never `automatic`
  Statistics statistics;                                ///< of the last repetition, with median times
  double first_quartile_ms = 0, third_quartile_ms = 0;  ///< of `ms.total` of the repetitions
  double wall_ms = 0;          ///< median time that the caller waited, from setting positions to having contacts
  int repetitions = 0;         ///< that were measured
  int threads = 0;             ///< that the CPU was allowed
  std::uint64_t checksum = 0;  ///< of the contacts: equal for equal contacts
  std::string left_out;        ///< why nothing was measured and all figures are 0; empty: it was
};

/// Seconds after which a measurement ends, however many repetitions are left.
constexpr double kMostSeconds = 20;

/// Margin of either side in discrete detection, in edges: contacts are what is within a tenth of an edge. Continuous
/// detection has no margin: contacts are collisions.
constexpr double kMarginInEdges = 0.05;

/// Detects `repetitions` times after three warm-ups. Sets all positions before each detection, as a simulation does.
/// Left out where there is not enough memory.
Measurement measure(const DetectorScene& scene, const MeasuredOptions& options, int repetitions);

/// FNV-1a of contacts' bytes.
std::uint64_t checksum_of(Span<const std::byte> contacts);

/// A measurement that was not made.
Measurement left_out(const DetectorScene& scene, const MeasuredOptions& options, const std::string& reason);

/// Pairs of triangles whose middles share a cell of three times the largest triangle's radius: about what the broad
/// phase `uniform` has to enumerate, without doing so.
double estimate_uniform_tests(const DetectorScene& scene);

}  // namespace softcd::benchmarks

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "detector_scenes.hpp"
#include "softcd/softcd.hpp"

namespace softcd::benchmarks {

/// The settings of a measurement.
struct MeasuredOptions : PipelineOptions {
  /// Turns reuse_pairs off: each repetition is to measure a complete detection, although the positions are the same.
  MeasuredOptions() { reuse_pairs = false; }

  bool on_device = false;  ///< positions and contacts are in the device's memory
  bool rocks = false;      ///< every other detection has the step reversed
  bool is_paper = false;   ///< uses the printed broad phase (paper/scheme.hpp) instead of `broad_phase`
};

/// The result of one detector on one scene.
struct Measurement {
  std::string scene;
  MeasuredOptions options;                              ///< with the backend that was used, never `automatic`
  Statistics statistics;                                ///< of the last repetition, with median times
  double first_quartile_ms = 0, third_quartile_ms = 0;  ///< of `ms.total` of the repetitions
  double wall_ms = 0;                                   ///< median time from setting positions to having contacts
  int repetitions = 0;                                  ///< number of measured repetitions
  int threads = 0;                                      ///< number of threads that the CPU was allowed
  std::uint64_t checksum = 0;                           ///< of the contacts: equal for equal contacts
  std::string left_out;  ///< the reason why nothing was measured and all figures are 0; empty: measured
};

/// Seconds after which a measurement ends, even if repetitions are left.
constexpr double kMostSeconds = 20;

/// The margin of either side in discrete detection, in edges: features within a tenth of an edge are contacts.
/// Continuous detection has no margin: contacts are collisions.
constexpr double kMarginInEdges = 0.05;

/// Detects `repetitions` times after three warm-ups. Sets all positions before each detection, as a simulation does.
/// Returns a left_out measurement where memory does not suffice.
Measurement measure(const DetectorScene& scene, const MeasuredOptions& options, int repetitions);

/// Returns the FNV-1a hash of the contacts' bytes.
std::uint64_t checksum_of(Span<const std::byte> contacts);

/// Returns a measurement that was not made.
Measurement left_out(const DetectorScene& scene, const MeasuredOptions& options, const std::string& reason);

/// Estimates the tests of the broad phase `uniform` without running it. Counts pairs of triangles whose middles share a
/// cell of three times the largest triangle's radius.
double estimate_uniform_tests(const DetectorScene& scene);

}  // namespace softcd::benchmarks

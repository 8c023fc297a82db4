#pragma once

#include <cstdint>

#include "softcd/core/types.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Where detections are computed.
enum class Backend : std::uint32_t {
  automatic,  ///< CUDA where there is a usable device, else the CPU, also when the device fails
  cpu,        ///< oneTBB
  cuda,       ///< an NVIDIA GPU; an error where there is none, or when it fails
};

/// Milliseconds spent per stage of the last detection.
struct StageTimes {
  double total = 0;        ///< the whole detection
  double volumes = 0;      ///< bounding volumes of triangles, and the choice of the grid
  double subdivision = 0;  ///< large triangles split for the grid
  double assignment = 0;   ///< triangles registered in cells
  double sort = 0;         ///< entries by cell, contacts into their order
  double tests = 0;        ///< pairs of triangles in a cell
  double features = 0;     ///< pairs of features of these
  double narrow = 0;       ///< candidates tested, contacts written
  double transfer = 0;     ///< between host and device
};

/// Counts of the last detection.
struct Statistics {
  Backend backend = Backend::cpu;        ///< where it was computed: never `automatic`
  std::uint64_t bodies = 0;              ///< in the scene
  std::uint64_t triangles = 0;           ///< in the scene
  std::uint64_t vertices = 0;            ///< in the scene
  std::uint64_t edges = 0;               ///< in the scene
  std::uint64_t active_triangles = 0;    ///< that can reach a partner: bodies' boxes and filters leave them in
  std::uint64_t left_out_triangles = 0;  ///< with a vertex that is not finite
  double mean_radius = 0;                ///< clipped mean of the active triangles' bounding radii
  /// Unit: the positions'. 0 where the CPU sweeps a scene of few triangles along an axis instead: each active triangle
  /// has one entry then, and there are no cells.
  double cell_size = 0;
  std::uint64_t split_triangles = 0;  ///< that are registered by their virtual children
  std::uint64_t children = 0;         ///< virtual triangles that stand for the split ones
  std::uint64_t big_triangles = 0;    ///< tested against all instead of through the grid
  std::uint64_t entries = 0;          ///< (cell, triangle) registrations
  std::uint64_t cells = 0;            ///< occupied
  std::uint64_t tests = 0;            ///< enumerated triangle pairs
  /// Only pairs that an earlier detection had kept were tested: see QueryOptions::reuse_pairs. There are no entries and
  /// cells then, and mean_radius and cell_size are that detection's.
  bool reused_pairs = false;
  std::uint64_t triangle_pairs = 0;  ///< that passed every test of the broad phase; neighbours are listed instead
  std::uint64_t flagged_pairs = 0;   ///< pairs of split triangles that had to be made unique
  std::uint64_t vt_candidates = 0;   ///< vertices with triangles that were tested
  std::uint64_t ee_candidates = 0;   ///< pairs of edges that were tested
  std::uint64_t vt_contacts = 0;     ///< vertices with triangles that touch
  std::uint64_t ee_contacts = 0;     ///< pairs of edges that touch
  /// Of the contacts, those that `conservative` reports because it could not tell within its bound on work.
  std::uint64_t unsettled_contacts = 0;
  double earliest_toi = 1;  ///< 1 when nothing hits
  /// These three are also there after OutOfMemory. The most of the backend's memory that was held at once since
  /// memory_limit was last changed; never more than the limit.
  std::uint64_t peak_bytes = 0;
  std::uint64_t reruns = 0;  ///< stages, or detections, repeated because a buffer had to grow or memory did not suffice
  std::uint64_t chunks = 1;  ///< parts that the pairs were tested in: so that memory suffices, or as they are many
  StageTimes ms;             ///< how long it took
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd

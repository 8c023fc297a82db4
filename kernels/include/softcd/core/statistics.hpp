#pragma once

#include <cstdint>

#include "softcd/core/types.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// The processor that computes detections.
enum class Backend : std::uint32_t {
  automatic,  ///< CUDA where a usable device exists, else the CPU. Falls back to the CPU when the device fails
  cpu,        ///< oneTBB
  cuda,       ///< an NVIDIA GPU; an error where none exists, or when it fails
};

/// Milliseconds spent per stage of the last detection.
struct StageTimes {
  double total = 0;        ///< the whole detection
  double volumes = 0;      ///< bounding volumes of triangles, and the choice of the grid
  double subdivision = 0;  ///< large triangles split for the grid
  double assignment = 0;   ///< triangles registered in cells
  double sort = 0;         ///< sorting of entries by cell, and of contacts
  double tests = 0;        ///< tests of pairs of triangles that share a cell
  double features = 0;     ///< candidates: pairs of features of those triangles
  double narrow = 0;       ///< tests of candidates, and writing of contacts
  double transfer = 0;     ///< copies between host and device
};

/// Counts of the last detection.
struct Statistics {
  Backend backend = Backend::cpu;        ///< the backend that computed it: never `automatic`
  std::uint64_t bodies = 0;              ///< in the scene
  std::uint64_t triangles = 0;           ///< in the scene
  std::uint64_t vertices = 0;            ///< in the scene
  std::uint64_t edges = 0;               ///< in the scene
  std::uint64_t active_triangles = 0;    ///< those whose body's box and filters allow a partner
  std::uint64_t left_out_triangles = 0;  ///< those with a vertex that is not finite
  double mean_radius = 0;                ///< clipped mean of the active triangles' bounding radii
  double cell_size = 0;                  ///< in the positions' unit
  std::uint64_t split_triangles = 0;     ///< those registered by their virtual children
  std::uint64_t children = 0;            ///< virtual triangles that represent the split ones
  std::uint64_t big_triangles = 0;       ///< those tested against all others, outside of the grid
  /// Registrations of a triangle in a cell. On the CPU a patch of up to 8 neighbouring triangles is registered as one.
  std::uint64_t entries = 0;
  std::uint64_t cells = 0;  ///< occupied cells
  std::uint64_t tests = 0;  ///< enumerated pairs of triangles, on the CPU of patches, in one cell
  /// Whether the detection tested pairs that an earlier one has kept, and searched only the pairs of triangles that
  /// have moved since: see QueryOptions::reuse_pairs. There are then no entries and no cells. mean_radius and cell_size
  /// are those of the detection that kept the pairs.
  bool reused_pairs = false;
  std::uint64_t looked_up_triangles = 0;  ///< triangles whose pairs were searched because they have moved
  /// Pairs of triangles that passed every test of the broad phase. Neighbours are on another list, and not counted.
  std::uint64_t triangle_pairs = 0;
  std::uint64_t flagged_pairs = 0;  ///< pairs of split triangles that were sorted and made unique
  std::uint64_t vt_candidates = 0;  ///< tested pairs of a vertex and a triangle
  std::uint64_t ee_candidates = 0;  ///< tested pairs of edges
  std::uint64_t vt_contacts = 0;    ///< touching pairs of a vertex and a triangle
  std::uint64_t ee_contacts = 0;    ///< touching pairs of edges
  /// The number of contacts that `conservative` reports because it reached its bound on work before it could decide.
  std::uint64_t unsettled_contacts = 0;
  double earliest_toi = 1;  ///< the earliest time of impact; 1 without contacts
  /// The most bytes of the backend's memory that were in use at once since memory_limit last changed. Never more than
  /// the limit. This and the next two members are valid after OutOfMemory, too.
  std::uint64_t peak_bytes = 0;
  std::uint64_t reruns = 0;  ///< repeated stages or detections: a buffer had to grow, or memory did not suffice
  std::uint64_t chunks = 1;  ///< parts in which the pairs were tested, to save memory or because they are many
  StageTimes ms;             ///< the time that it took
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd

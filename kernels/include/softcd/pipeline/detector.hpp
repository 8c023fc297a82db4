#pragma once

#include <functional>
#include <memory>
#include <stdexcept>

#include "softcd/core/contact.hpp"
#include "softcd/core/statistics.hpp"
#include "softcd/mesh/scene_view.hpp"

namespace softcd {

/// The device failed; what() names the stage.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Connectivity of all bodies, concatenated; host memory. See SceneView for the fields.
struct SceneTopology {
  Span<const Triangle> triangles;
  Span<const Triangle> triangle_edges;
  Span<const Edge> edges;
  Span<const Ownership> ownership;
  Span<const std::uint32_t> triangle_body;
  Span<const std::uint32_t> vertex_body;
  /// Of all bodies that list them, as NeighbourFeatures.
  Span<const std::uint64_t> vertex_triangle_neighbours, edge_edge_neighbours;
};

/// The bodies and their pairs; see SceneView.
struct SceneBodies {
  Span<const SceneBody> bodies;
  Span<const std::uint64_t> partner_begin;
  Span<const std::uint32_t> partners;
};

struct DetectionSettings {
  Detection detection;
  Accuracy accuracy;
  BroadPhase broad_phase;
  bool subdivision;
  float lambda;  ///< 0: see ChooseGrid
  float motion_margin;
  ContactRule contact_rule;
  bool vertex_triangle;  ///< some pair of bodies wants these candidates
  bool edge_edge;
  bool both_ends;  ///< x_t0 counts; else it was not written and nothing moves
};

/// Where the host writes the positions of the next detection. x_t0 may stay unwritten when only t1 counts.
struct PositionArrays {
  Vec3f* x_t0;
  Vec3f* x_t1;
};

/// One detection after another on one backend. Throws std::bad_alloc when memory runs out, DeviceError when
/// the device fails.
class Detector {
 public:
  virtual ~Detector() = default;

  /// Most bytes of the backend's memory to hold from now on; 0 for no limit. Gives back what is more than that. False
  /// when that was the topology too, which has to be set again.
  virtual bool set_memory_limit(std::uint64_t bytes) = 0;
  virtual void set_topology(const SceneTopology& topology) = 0;
  virtual PositionArrays position_arrays() = 0;
  /// Returns once everything in host memory has been read.
  virtual void start(const SceneBodies& bodies, const DetectionSettings& settings) = 0;
  /// Contacts stay valid until the next start(). Fills all of `statistics` that the detection determines.
  virtual Span<const Contact> finish(Statistics& statistics) = 0;
  /// Fills peak_bytes, reruns and chunks, also of a detection that failed.
  virtual void report_memory(Statistics& statistics) const = 0;
};

std::unique_ptr<Detector> make_cpu_detector();

/// Makes a detector, or throws as one does.
using DetectorFactory = std::function<std::unique_ptr<Detector>()>;

/// For detectors on the CUDA device that is current during this call, whichever is current when they are made and used.
/// `stream` is a cudaStream_t of that device to enqueue on, null for one of their own. Empty when the library was built
/// without CUDA. Throws DeviceError.
DetectorFactory cuda_detector_factory(void* stream);

/// Why no CUDA device can be used; empty when one can.
const char* cuda_problem();

}  // namespace softcd

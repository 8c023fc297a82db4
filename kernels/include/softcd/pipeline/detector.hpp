#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

#include "softcd/core/contact.hpp"
#include "softcd/core/statistics.hpp"
#include "softcd/grid/partition.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/mesh/predicted_positions.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/mesh/vertex_stars.hpp"
#include "softcd/pipeline/spatial_queries.hpp"

namespace softcd {

/// The device failed; what() names the stage.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Elements begin <= i < end of an array.
struct Range {
  std::uint64_t begin, end;
};

/// See FeatureFilters for the fields. A field is empty if no body uses it.
struct FilterArrays {
  Span<const VertexFilter> vertices;
  Span<const std::uint64_t> ring_begin;
  Span<const std::uint32_t> ring_vertices;
  Span<const Vec3f> x_rest;
};

/// The meshes and positions of all bodies, one body behind the other in ascending order of ids; host memory. See
/// SceneView for the fields. Between bodies there may be triangles that are kLeftOut, and unused vertices and edges.
struct SceneArrays {
  Span<const Vec3f> x_t0, x_t1;
  Span<const Vec3d> full_t0, full_t1;  ///< filled as far as the next work covers_rounding, and may be empty else
  Span<const Triangle> triangles;
  Span<const TriangleEdges> triangle_edges;
  Span<const Edge> edges;
  Span<const Ownership> ownership;
  Span<const std::uint32_t> patch_triangles;  ///< none where there are no patches
  Span<const std::uint32_t> triangle_body, vertex_body;
  /// NeighbourFeatures of all bodies that list them, in any order, with kNoFeatures among them.
  Span<const std::uint64_t> vertex_triangle_neighbours, edge_edge_neighbours;
  /// The stars of vertices of bodies that have_stars, in any order.
  Span<const VertexStar> stars;
  std::uint64_t revision;  ///< changes with the meshes, and with what their triangles own
  FilterArrays filters{};
};

/// Positions on the detector's device, of vertices from `first` on.
struct DevicePositions {
  GivenPositions positions;
  std::uint64_t first, count;
};

/// Whether positions on a device are as predicted.
struct PredictionVerdict {
  const std::uint32_t* is_as_predicted = nullptr;  ///< on the device; null if the host has read them
  void* known = nullptr;                           ///< the cudaEvent_t after which that is known
};

/// The surveys of runs of vertices on a device, and whether they are as predicted.
struct SeenPositions {
  Span<const StepSurvey> surveys;
  bool are_as_predicted = false;
};

/// The changed parts of SceneArrays.
struct SceneChanges {
  std::vector<Range> vertices, triangles, edges, patches;  ///< of the meshes
  std::vector<Range> ownership;                            ///< of triangles that are not in `triangles`
  std::vector<Range> x_t0, x_t1;
  /// Positions that are not in the arrays, which begin at this origin.
  std::vector<DevicePositions> device_x_t0, device_x_t1;
  Vec3d origin{0, 0, 0};
  // The same for SceneArrays::full_t0 and full_t1:
  std::vector<Range> full_t0, full_t1;
  std::vector<DevicePositions> device_full_t0, device_full_t1;
  std::vector<Range> vertex_triangle_neighbours, edge_edge_neighbours, stars;
  bool filters = false;  ///< all of them
  PredictionVerdict
      verdict{};  ///< of positions on the device; unless they are as predicted, the next detection finds nothing
};

/// The bodies and their pairs in one detection; see SceneView.
struct SceneBodies {
  Span<const SceneBody> bodies;
  Span<const std::uint64_t> partner_begin;
  Span<const std::uint32_t> partners;
  std::uint64_t number = 0;  ///< equal only if all of it is, for one query; 0 if that is not known

  Span<const std::uint32_t> row(std::size_t body) const {
    return {partners.data() + partner_begin[body], partner_begin[body + 1] - partner_begin[body]};
  }
};

struct DetectionSettings {
  Detection detection;
  Accuracy accuracy;
  BroadPhase broad_phase;
  bool subdivision;
  float cell_size_factor;  ///< 0: see ChooseGrid
  float motion_margin;
  ContactRule contact_rule;
  bool vertex_triangle;  ///< some pair of bodies wants these candidates
  bool edge_edge;
  bool both_ends;        ///< both t0 and t1 count, and something moves
  bool at_t0;            ///< if not both count: t0 does
  bool covers_rounding;  ///< some positions are no floats, and count as they were given
  bool reuses_pairs;
  bool contacts_stay;  ///< in the backend's memory
  Partition partition;

  friend bool operator==(const DetectionSettings&, const DetectionSettings&) = default;
};

/// Contacts in the backend's memory, valid when the enqueued work has run; see PendingContacts.
struct StayingContacts {
  const Contact* data = nullptr;
  std::uint64_t capacity = 0;
  const ContactCounts* counts = nullptr;  ///< null until all is enqueued
  const std::uint64_t* body_begin = nullptr;
  std::uint32_t body_ids = 0;
  void* ready = nullptr;
};

/// The number of tests of a rank, and where they are: cells[i] is the cell of the test before which i / kTestSamples of
/// all tests lie.
struct TestSamples {
  std::uint64_t tests = 0;
  std::uint32_t cells[kTestSamples] = {};
};

/// The memory of one query or probe on a backend. A query has its last contacts, and the sizes that its lists needed; a
/// probe has its last answers. May outlive the detector.
class QueryMemory {
 public:
  virtual ~QueryMemory() = default;

  /// Releases the memory on the detector's account, and the last results with it.
  virtual void release() = 0;
};

/// The purpose that memory ran out for, and the bytes that would be held with it; 0 if that is not known.
struct MemoryNeed {
  enum class For : std::uint8_t { scene, lists, contacts };

  For what = For::scene;
  std::uint64_t bytes = 0;
  std::uint64_t contacts = 0;  ///< found before
};

/// The detections on one backend's copy of a scene, one after another. Throws std::bad_alloc when memory runs out,
/// DeviceError when the device fails.
class Detector {
 public:
  virtual ~Detector() = default;

  /// Sets the most bytes of the backend's memory to hold from now on; 0 for no limit. Releases what exceeds it, also of
  /// `query`, which starts next. Returns false if it released the scene; then all of the scene counts as changed.
  virtual bool set_memory_limit(std::uint64_t bytes, QueryMemory& query) = 0;
  /// Sets the scene of the next detections. It stays where it is, unchanged, until the last of them is finished. If
  /// this throws, all of the scene counts as changed.
  virtual void set_scene(const SceneArrays& scene, const SceneChanges& changes) = 0;
  virtual std::unique_ptr<QueryMemory> make_query() = 0;
  /// Starts a detection. The previous one must be finished, or have failed. Reads `bodies` before it returns.
  /// Invalidates the contacts of the query's last detection.
  virtual void start(QueryMemory& query, const SceneBodies& bodies, const DetectionSettings& settings) = 0;
  /// Returns the contacts of the detection that was started last, if they stay on the backend. Valid as long as
  /// contacts are.
  virtual StayingContacts staying() const = 0;
  /// Waits for the detection that was started last, and returns its contacts. They are on the host unless they stay on
  /// the backend, and valid until the query's next start(). Fills all of `statistics` that the detection determines.
  virtual Span<const Contact> finish(Statistics& statistics) = 0;
  virtual std::unique_ptr<QueryMemory> make_probe() = 0;
  /// Calls ask() with an object that answers questions about the scene, in a probe's memory. No detection may run.
  virtual void answer(QueryMemory& probe, const ProbedScene& scene, const Questions& ask) = 0;
  /// Fills peak_bytes, reruns and chunks, also of a detection that failed.
  virtual void report_memory(Statistics& statistics) const = 0;
  /// Returns the need of the call that threw std::bad_alloc.
  virtual MemoryNeed memory_need() const = 0;
  /// Returns the samples of the last detection that was finished, if it was one rank's.
  virtual TestSamples test_samples() const = 0;
};

/// Reads positions in a device's memory for the host. Throws DeviceError, or std::bad_alloc.
class DevicePositionReader {
 public:
  virtual ~DevicePositionReader() = default;

  /// Returns the device, as cudaGetDeviceCount counts.
  virtual int device() const = 0;
  /// Whether the device can read there.
  virtual bool can_read(const void* data) = 0;
  /// Makes later reads wait for this cudaEvent_t.
  virtual void wait_for(void* ready) = 0;
  /// Returns the survey of each run of vertices, with positions relative to the origin. Leaves t0 out if it is neither
  /// t1 nor needed. Valid until the next call.
  virtual Span<const StepSurvey> survey(Span<const SurveyedVertices> vertices, Vec3d origin, bool needs_t0) = 0;
  /// Enqueues a survey, and checks that each run is within its `predicted` survey, and that all together are as `scene`
  /// says.
  virtual PredictionVerdict look(Span<const SurveyedVertices> vertices, Span<const StepSurvey> predicted,
                                 const Predicted& scene, bool needs_t0) = 0;
  /// Waits for the survey of look(), and returns its result. Valid until the next call.
  virtual SeenPositions seen() = 0;
  /// Copies positions to the host, one behind the other.
  virtual void copy(const GivenPositions& from, std::uint64_t count, void* to) = 0;
};

/// Makes a reader. Throws what a reader throws.
using DevicePositionReaderFactory = std::function<std::unique_ptr<DevicePositionReader>()>;

/// Makes a detector. Throws what a detector throws.
using DetectorFactory = std::function<std::unique_ptr<Detector>()>;

std::unique_ptr<Detector> make_cpu_detector();

/// Returns a factory of detectors on a CUDA device. They use it whichever device is current when they are made and
/// used. -1 is the device that is current during this call. `stream` is a cudaStream_t of that device to enqueue on,
/// null for one of their own. Empty if the library was built without CUDA. Throws DeviceError.
DetectorFactory cuda_detector_factory(int device, void* stream);

/// Returns a factory of readers on a CUDA device; see cuda_detector_factory.
DevicePositionReaderFactory cuda_position_reader_factory(int device);

/// Returns why no CUDA device can be used; empty if one can.
const char* cuda_problem();

/// Allocates page-locked memory for arrays that CUDA devices read, so that they read at full speed; null if there is
/// none. free_shared_memory releases it.
void* allocate_shared_memory(std::uint64_t bytes);
void free_shared_memory(void* memory);

}  // namespace softcd

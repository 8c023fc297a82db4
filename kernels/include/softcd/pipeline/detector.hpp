#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

#include "softcd/core/contact.hpp"
#include "softcd/core/statistics.hpp"
#include "softcd/grid/partition.hpp"
#include "softcd/mesh/foreseen_positions.hpp"
#include "softcd/mesh/scene_view.hpp"
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

/// See FeatureFilters for the fields; empty where no body has the like.
struct FilterArrays {
  Span<const VertexFilter> vertices;
  Span<const std::uint64_t> ring_begin;
  Span<const std::uint32_t> ring_vertices;
  Span<const Vec3f> x_rest;
};

/// All bodies' meshes and positions, one body behind the other in ascending order of ids; host memory. See SceneView
/// for the fields. Between bodies there may be triangles that are kLeftOut, and vertices and edges that none has.
struct SceneArrays {
  Span<const Vec3f> x_t0, x_t1;
  Span<const Vec3d> full_t0, full_t1;  ///< filled as far as the next detection covers_rounding, and may be empty else
  Span<const Triangle> triangles;
  Span<const TriangleEdges> triangle_edges;
  Span<const Edge> edges;
  Span<const Ownership> ownership;
  Span<const std::uint32_t> patch_triangles;  ///< none where there are no patches
  Span<const std::uint32_t> triangle_body, vertex_body;
  /// What all bodies that list them have, in any order, as NeighbourFeatures, with kNoFeatures among them.
  Span<const std::uint64_t> vertex_triangle_neighbours, edge_edge_neighbours;
  std::uint64_t revision;  ///< another one where meshes, or what their triangles own, have changed
  FilterArrays filters{};
};

/// Positions on the detector's device, of vertices from `first` on.
struct DevicePositions {
  GivenPositions positions;
  std::uint64_t first, count;
};

/// Whether positions on a device are as they were foreseen.
struct ForeseenVerdict {
  const std::uint32_t* is_as_foreseen = nullptr;  ///< on the device; null where the host has seen them
  void* known = nullptr;                          ///< the cudaEvent_t after which that is known
};

/// What a look at positions on a device has seen of each run of vertices, and whether that is as was foreseen.
struct SeenPositions {
  Span<const StepSurvey> surveys;
  bool are_as_foreseen = false;
};

/// What of SceneArrays is not as it was.
struct SceneChanges {
  std::vector<Range> vertices, triangles, edges, patches;  ///< of the meshes
  std::vector<Range> ownership;                            ///< of triangles that are not in `triangles`
  std::vector<Range> x_t0, x_t1;
  /// Positions that are not in the arrays, which begin at this origin.
  std::vector<DevicePositions> device_x_t0, device_x_t1;
  Vec3d origin{0, 0, 0};
  // Of SceneArrays::full_t0 and full_t1, the same:
  std::vector<Range> full_t0, full_t1;
  std::vector<DevicePositions> device_full_t0, device_full_t1;
  std::vector<Range> vertex_triangle_neighbours, edge_edge_neighbours;
  bool filters = false;  ///< all of them
  ForeseenVerdict
      verdict{};  ///< of the positions on the device: the next detection finds nothing where it is against them
};

/// The bodies and their pairs in one detection; see SceneView.
struct SceneBodies {
  Span<const SceneBody> bodies;
  Span<const std::uint64_t> partner_begin;
  Span<const std::uint32_t> partners;
  std::uint64_t number = 0;  ///< the same only where all of it is, of one query's; 0 where that is not known

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
  bool both_ends;        ///< t0 and t1 count, and something moves
  bool at_t0;            ///< where not both count: t0 does
  bool covers_rounding;  ///< some positions are no floats, and count as they were given
  bool reuses_pairs;
  bool contacts_stay;  ///< in the backend's memory
  Partition partition;

  friend bool operator==(const DetectionSettings&, const DetectionSettings&) = default;
};

/// Contacts that stay in the backend's memory, once what was enqueued has run; see PendingContacts.
struct StayingContacts {
  const Contact* data = nullptr;
  std::uint64_t capacity = 0;
  const ContactCounts* counts = nullptr;  ///< null until all is enqueued
  const std::uint64_t* body_begin = nullptr;
  std::uint32_t body_ids = 0;
  void* ready = nullptr;
};

/// How many tests a rank has made, and where: the cell of the test before which i / kTestSamples of them lie.
struct TestSamples {
  std::uint64_t tests = 0;
  std::uint32_t cells[kTestSamples] = {};
};

/// What one query keeps on a backend from one detection to the next: its last contacts, and what it has learnt of the
/// sizes of lists; or one probe its last answers. May outlive the detector.
class QueryMemory {
 public:
  virtual ~QueryMemory() = default;

  /// Gives back what is on the detector's account, and with it what was found last.
  virtual void release() = 0;
};

/// What memory ran out for, and how many bytes would have been held with it; 0 where that is not known.
struct MemoryNeed {
  enum class For : std::uint8_t { scene, lists, contacts };

  For what = For::scene;
  std::uint64_t bytes = 0;
  std::uint64_t contacts = 0;  ///< that had been found
};

/// The detections on one backend's copy of a scene, one after another. Throws std::bad_alloc when memory runs out,
/// DeviceError when the device fails.
class Detector {
 public:
  virtual ~Detector() = default;

  /// Most bytes of the backend's memory to hold from now on; 0 for no limit. Gives back what is more than that,
  /// `query`'s included, which starts next. False when that was the scene too, all of which has changed then.
  virtual bool set_memory_limit(std::uint64_t bytes, QueryMemory& query) = 0;
  /// The scene of the next detections, which stays where it is, unchanged, until the last of them is finished. Where
  /// this throws, all of the scene has changed.
  virtual void set_scene(const SceneArrays& scene, const SceneChanges& changes) = 0;
  virtual std::unique_ptr<QueryMemory> make_query() = 0;
  /// The detection before was finished, or failed. Reads `bodies` before it returns. Contacts of the query's last
  /// detection are gone.
  virtual void start(QueryMemory& query, const SceneBodies& bodies, const DetectionSettings& settings) = 0;
  /// Of the detection that was started last, where contacts stay. Valid as contacts are.
  virtual StayingContacts staying() const = 0;
  /// Waits for the detection that was started last, and returns its contacts, on the host unless they stay, which are
  /// valid until the query's next start(). Fills all of `statistics` that the detection determines.
  virtual Span<const Contact> finish(Statistics& statistics) = 0;
  virtual std::unique_ptr<QueryMemory> make_probe() = 0;
  /// Calls ask() with what answers about the scene, in a probe's memory. No detection runs.
  virtual void answer(QueryMemory& probe, const ProbedScene& scene, const Questions& ask) = 0;
  /// Fills peak_bytes, reruns and chunks, also of a detection that failed.
  virtual void report_memory(Statistics& statistics) const = 0;
  /// Of the call that has thrown std::bad_alloc.
  virtual MemoryNeed memory_need() const = 0;
  /// Of the last detection that was finished, where it was one rank's.
  virtual TestSamples test_samples() const = 0;
};

/// Reads positions in a device's memory for the host. Throws DeviceError, or std::bad_alloc.
class DevicePositionReader {
 public:
  virtual ~DevicePositionReader() = default;

  /// As cudaGetDeviceCount counts them.
  virtual int device() const = 0;
  /// Whether the device can read there.
  virtual bool can_read(const void* data) = 0;
  /// What is read from now on is there after this cudaEvent_t.
  virtual void wait_for(void* ready) = 0;
  /// What is known of each run of vertices when they are placed relative to the origin; nothing of t0 where it is not
  /// t1 and not needed. Valid until the next call.
  virtual Span<const StepSurvey> survey(Span<const SurveyedVertices> vertices, Vec3d origin, bool needs_t0) = 0;
  /// Enqueues a survey, and whether each run is within what is `foreseen` of it, and all together as `scene` says.
  virtual ForeseenVerdict look(Span<const SurveyedVertices> vertices, Span<const StepSurvey> foreseen,
                               const Foreseen& scene, bool needs_t0) = 0;
  /// What the last look has seen, once it has. Valid until the next call.
  virtual SeenPositions seen() = 0;
  /// To the host, one behind the other.
  virtual void copy(const GivenPositions& from, std::uint64_t count, void* to) = 0;
};

/// Makes a reader, or throws as one does.
using DevicePositionReaderFactory = std::function<std::unique_ptr<DevicePositionReader>()>;

/// Makes a detector, or throws as one does.
using DetectorFactory = std::function<std::unique_ptr<Detector>()>;

std::unique_ptr<Detector> make_cpu_detector();

/// For detectors on a CUDA device, whichever is current when they are made and used; -1 for the one that is current
/// during this call. `stream` is a cudaStream_t of that device to enqueue on, null for one of their own. Empty when the
/// library was built without CUDA. Throws DeviceError.
DetectorFactory cuda_detector_factory(int device, void* stream);

/// For positions on a CUDA device, as cuda_detector_factory.
DevicePositionReaderFactory cuda_position_reader_factory(int device);

/// Why no CUDA device can be used; empty when one can.
const char* cuda_problem();

/// Memory for arrays that CUDA devices read, page-locked, so that they do at full speed; null where there is none.
/// Given back by free_shared_memory.
void* allocate_shared_memory(std::uint64_t bytes);
void free_shared_memory(void* memory);

}  // namespace softcd

#include "viewer/detection_grid.hpp"

#include <algorithm>
#include <memory>

#include "cpu_backend.hpp"
#include "query_core.hpp"
#include "softcd/pipeline/detector_on.hpp"

namespace softcd::demo {
namespace {

static_assert(GridEntry::kMaskBits == kMaskBits);

/// The intermediate results of the stages.
struct GridRecord {
  std::vector<SplitRoot> splits;
  std::vector<std::uint32_t> keys;
  std::vector<Entry> entries;
  std::vector<std::uint32_t> partner_counts;  ///< of each entry
  std::vector<Kdop18> volumes;                ///< of each triangle
};

template <class T>
std::vector<T> copy_of(const T* values, std::uint64_t count) {
  return std::vector<T>(values, values + count);
}

/// The CPU backend, which also records the intermediate results.
class RecordingBackend : public CpuBackend {
 public:
  /// The viewer shows single triangles in the grid.
  static constexpr bool kHasPatches = false;

  RecordingBackend(MemoryAccount& account, GridRecord* record) : CpuBackend(account), record_(*record) {}

  using CpuBackend::for_each;
  using CpuBackend::for_each_append;

  void for_each(const char* label, Count splits, const CountChildren<SplitRoot>& count_children) {
    CpuBackend::for_each(label, splits, count_children);
    record_.splits = copy_of(count_children.splits, splits.get());
  }

  template <bool kSwept>
  void for_each_append(const char* label, Count entries, const PrepareEntry<ExactControl, kSwept>& prepare_entry,
                       Appender<CountTarget> cells) {
    CpuBackend::for_each_append(label, entries, prepare_entry, cells);
    record_.keys = copy_of(prepare_entry.keys, entries.get());
    record_.entries = copy_of(prepare_entry.entries, entries.get());
    record_.partner_counts = copy_of<std::uint32_t>(prepare_entry.partner_count, entries.get());
    record_.volumes = copy_of(prepare_entry.volumes, prepare_entry.scene.triangle_count);
  }

 private:
  GridRecord& record_;
};

}  // namespace

DetectionGrid::DetectionGrid(const std::vector<GridBody>& bodies, const QueryOptions& options) {
  GridRecord record;
  const auto make_detector = [&record] { return std::make_unique<DetectorOn<RecordingBackend>>(&record); };
  softcd::SceneOptions on_cpu;
  on_cpu.backend = Backend::cpu;
  const auto scene =
      std::make_shared<detail::SceneCore>(on_cpu, LogCallback(), DetectorFactories{make_detector, {}, {}});
  detail::QueryCore query(scene, options);
  for (const GridBody& body : bodies) scene->set_positions(scene->add_body(body.desc), body.x_t0, body.x_t1);
  query.wait(query.start(Pairs::all));
  counts_ = query.statistics();

  const SceneStore& store = scene->store();
  const SceneArrays arrays = store.arrays();
  origin_ = store.positions().origin();
  x_t1_.assign(arrays.x_t1.begin(), arrays.x_t1.end());
  triangles_.assign(arrays.triangles.begin(), arrays.triangles.end());
  for (const Body& body : store.bodies()) first_triangles_.push_back(body.triangles.first);
  for (const SplitRoot& split : record.splits) splits_.push_back({split.root, static_cast<int>(split.level)});
  inverse_cell_size_ = 1.0F / static_cast<float>(counts_.cell_size);
  for (std::size_t i = 0; i < record.entries.size(); ++i) {
    const Entry& entry = record.entries[i];
    const std::uint32_t index = key_cell(record.keys[i]);
    if (cells_.empty() || cells_.back().index != index) {
      const IntegerDop cells = integer_dop(record.volumes[entry.root], inverse_cell_size_);
      const Cell cell = cell_near(index, {cells.lo[0], cells.lo[1], cells.lo[2]});
      const Vec3d low = {static_cast<double>(cell.x), static_cast<double>(cell.y), static_cast<double>(cell.z)};
      cells_.push_back({index, origin_ + counts_.cell_size * low, i, 0, 0});
    }
    ++cells_.back().entry_count;
    cells_.back().tests += record.partner_counts[i];
    const std::uint32_t mask = entry.bits & ((1U << kMaskBits) - 1U);
    entries_.push_back({entry.root, mask, missing_face_neighbours(mask)});
  }
}

const OccupiedCell* DetectionGrid::cell_around(std::uint32_t triangle) const {
  if (cells_.empty()) return nullptr;
  const auto& v = triangles_[triangle].v;
  const Vec3f centroid = (1.0F / 3.0F) * (x_t1_[v[0]] + x_t1_[v[1]] + x_t1_[v[2]]);
  const std::uint32_t index = cell_index(cell_of(centroid, inverse_cell_size_));
  const auto found =
      std::lower_bound(cells_.begin(), cells_.end(), index,
                       [](const OccupiedCell& cell, std::uint32_t wanted) { return cell.index < wanted; });
  return found != cells_.end() && found->index == index ? &*found : nullptr;
}

std::size_t DetectionGrid::body_of(std::uint32_t triangle) const {
  const auto next = std::upper_bound(first_triangles_.begin(), first_triangles_.end(), triangle);
  return static_cast<std::size_t>(next - first_triangles_.begin()) - 1;
}

std::vector<const OccupiedCell*> DetectionGrid::cells_of(std::uint32_t triangle) const {
  std::vector<const OccupiedCell*> found;
  for (const OccupiedCell& cell : cells_) {
    const Span<const GridEntry> here = entries(cell);
    if (std::any_of(here.begin(), here.end(), [&](const GridEntry& entry) { return entry.triangle == triangle; })) {
      found.push_back(&cell);
    }
  }
  return found;
}

std::vector<DetectionGrid::Corners> DetectionGrid::children_of(std::uint32_t triangle) const {
  const auto split = std::find_if(splits_.begin(), splits_.end(),
                                  [&](const SplitTriangle& candidate) { return candidate.triangle == triangle; });
  if (split == splits_.end()) return {};
  Vec3f corners[3];
  for (int i = 0; i < 3; ++i) corners[i] = x_t1_[triangles_[triangle].v[i]];
  std::vector<Corners> children;
  for (std::uint32_t child = 0; child < 1U << (2 * split->level); ++child) {
    const ChildWeights weights = child_weights(split->level, child);
    Corners at_t1;
    for (int i = 0; i < 3; ++i) {
      at_t1[static_cast<std::size_t>(i)] = origin_ + vec3_cast<double>(child_corner(weights, i, corners));
    }
    children.push_back(at_t1);
  }
  return children;
}

}  // namespace softcd::demo

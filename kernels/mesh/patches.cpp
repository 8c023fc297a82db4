#include "softcd/mesh/patches.hpp"

#include <algorithm>
#include <array>

namespace softcd {
namespace {

/// The triangles at each side of each triangle. At most two triangles are joined at a side, so that a side of many
/// triangles costs no more than others.
class SideNeighbours {
 public:
  explicit SideNeighbours(const MeshView& mesh) : neighbours_(mesh.triangles.size(), {{kNoIndex, kNoIndex, kNoIndex}}) {
    std::vector<std::uint32_t> last_side(mesh.edges.size(), kNoIndex);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::uint32_t side = 0; side < 3; ++side) {
        const std::uint32_t edge = mesh.triangle_edges[t].e[side];
        if (edge == kNoIndex) continue;
        std::uint32_t& last = last_side[edge - mesh.first_edge];
        if (last == kNoIndex) {
          last = 3 * t + side;
        } else if (last != kJoined && last / 3 != t) {
          neighbours_[t][side] = last / 3;
          neighbours_[last / 3][last % 3] = t;
          last = kJoined;
        }
      }
    }
  }

  const std::array<std::uint32_t, 3>& of(std::uint32_t t) const { return neighbours_[t]; }

 private:
  static constexpr std::uint32_t kJoined = kNoIndex - 1;

  std::vector<std::array<std::uint32_t, 3>> neighbours_;
};

/// Grows patches until all triangles are in one.
class PatchGrowth {
 public:
  explicit PatchGrowth(const MeshView& mesh) : sides_(mesh), is_placed_(mesh.triangles.size(), 0) {
    order_.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
    order_.triangles.reserve(mesh.triangles.size() + mesh.triangles.size() / 4);
  }

  PatchOrder run() {
    for (std::uint32_t t = 0; t < is_placed_.size(); ++t) {
      if (is_placed_[t] == 0) grow_from(t);
      // Patches beside the first ones leave the fewest triangles between them.
      for (; next_ < placed_.size(); ++next_) {
        for (const std::uint32_t beside : sides_.of(placed_[next_])) {
          if (beside != kNoIndex && is_placed_[beside] == 0) grow_from(beside);
        }
      }
    }
    for (const std::uint32_t t : few_) order_.triangles.push_back(t);
    fill_patch();
    return std::move(order_);
  }

 private:
  /// The fewest triangles of a patch. Those of smaller ones are put together, and need not be near each other.
  static constexpr std::size_t kFewest = 3;

  /// A triangle beside the patch that grows.
  struct Rim {
    std::uint32_t triangle;
    std::uint32_t shared_sides;
  };

  void fill_patch() {
    while (order_.triangles.size() % kPatchSize != 0) order_.triangles.push_back(kNoIndex);
  }

  void grow_from(std::uint32_t seed) {
    rim_.clear();
    const std::size_t first = placed_.size();
    place(seed);
    while (placed_.size() - first < kPatchSize && !rim_.empty()) {
      // Takes the first of equal ones, which is nearest to the seed.
      const auto best = std::max_element(rim_.begin(), rim_.end(),
                                         [](const Rim& a, const Rim& b) { return a.shared_sides < b.shared_sides; });
      const std::uint32_t t = best->triangle;
      rim_.erase(best);
      place(t);
    }
    const bool are_few = placed_.size() - first < kFewest;
    std::vector<std::uint32_t>& where = are_few ? few_ : order_.triangles;
    where.insert(where.end(), placed_.begin() + static_cast<std::ptrdiff_t>(first), placed_.end());
    if (!are_few) fill_patch();
  }

  void place(std::uint32_t t) {
    is_placed_[t] = 1;
    placed_.push_back(t);
    for (const std::uint32_t beside : sides_.of(t)) {
      if (beside == kNoIndex || is_placed_[beside] != 0) continue;
      const auto known = std::find_if(rim_.begin(), rim_.end(), [&](const Rim& rim) { return rim.triangle == beside; });
      if (known == rim_.end()) {
        rim_.push_back({beside, 1});
      } else {
        ++known->shared_sides;
      }
    }
  }

  SideNeighbours sides_;
  std::vector<std::uint8_t> is_placed_;
  PatchOrder order_;
  std::vector<std::uint32_t> placed_;  ///< in order
  std::size_t next_ = 0;               ///< in placed_: the triangles beside those before it are placed
  std::vector<std::uint32_t> few_;
  std::vector<Rim> rim_;
};

}  // namespace

PatchOrder patch_order(const MeshView& mesh) {
  return PatchGrowth(mesh).run();
}

}  // namespace softcd

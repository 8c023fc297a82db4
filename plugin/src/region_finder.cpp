#include "region_finder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "curve_length.hpp"
#include "softcd/math/box.hpp"

namespace softcd::detail {
namespace {

constexpr std::uint32_t kNoPatch = kNoIndex;
/// The index of a point that is no vertex, for perturbed_side().
constexpr std::uint32_t kFarPoint = kNoIndex;

void sort_and_unify(std::vector<std::uint32_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

double area_of(const Surface& surface, std::uint32_t t) {
  const Triangle v = surface.triangle(t);
  const Vec3d a = surface.position(v.v[0]);
  return 0.5 * std::sqrt(squared_norm(cross(surface.position(v.v[1]) - a, surface.position(v.v[2]) - a)));
}

/// Returns how often a closed surface winds around a vertex of another one: the sum of its passages, with signs,
/// through the segment from the vertex to a point above the surface.
int winding_number(const Surface& surface, const Surface& of, std::uint32_t v) {
  const PerturbedPoint from = of.point(v);
  double highest = from.x.z;
  for (std::uint32_t i = 0; i < surface.mesh.vertex_count; ++i) {
    if (std::isfinite(surface.x[i].z)) highest = std::max(highest, surface.position(i).z);
  }
  const Vec3d above = {from.x.x, from.x.y, std::nextafter(highest, std::numeric_limits<double>::infinity())};
  const PerturbedPoint to = {above, of.number, kFarPoint};
  int winding = 0;
  for (std::uint32_t t = 0; t < surface.mesh.face_count(); ++t) {
    if (!surface.has_face(t)) continue;
    const Triangle triangle = surface.triangle(t);
    PerturbedPoint corners[3];
    for (int i = 0; i < 3; ++i) corners[i] = surface.point(triangle.v[i]);
    const auto misses = [&](int axis) {
      const auto [low, high] = std::minmax({corners[0].x[axis], corners[1].x[axis], corners[2].x[axis]});
      return low > from.x[axis] || high < from.x[axis];
    };
    if (misses(0) || misses(1)) continue;
    const Passage found = passage(from, to, corners);
    if (found.passes) winding += found.side_of_start;
  }
  return winding;
}

/// An edge between two sides.
struct Cut {
  std::uint32_t v[2];
  std::int32_t value;  ///< the winding number at v[1] less that at v[0]; 1 where only its parity counts
};

/// The regions of one surface by the curves with another one, or with itself.
class PairRegions {
 public:
  PairRegions(Span<const Surface> surfaces, const IntersectionCurves& found, SurfacePair pair)
      : surfaces_(surfaces),
        found_(found),
        surface_(surfaces[pair.surface]),
        other_(surfaces[pair.other]),
        has_inside_(other_.is_closed && pair.surface != pair.other) {}

  void add_trace(std::uint32_t curve, std::uint32_t line) { lines_.push_back({curve, line}); }

  void find(std::vector<FoundRegion>& regions) {
    list_cuts();
    flood();
    if (has_inside_) {
      wind();
    } else {
      colour();
    }
    collect(regions);
  }

 private:
  struct Line {
    std::uint32_t curve, line;
  };

  const Trace& trace(const Line& line) const { return found_.curves[line.curve].traces[line.line]; }

  /// Lists the edges of which the ends are on different sides.
  void list_cuts() {
    std::vector<std::uint32_t> nodes;
    for (const Line& line : lines_) nodes.insert(nodes.end(), trace(line).nodes.begin(), trace(line).nodes.end());
    sort_and_unify(nodes);
    for (std::size_t i = 0; i < nodes.size();) {
      const SurfaceEdge& edge = found_.nodes[nodes[i]].edge;
      std::int32_t value = 0;
      for (; i < nodes.size() && found_.nodes[nodes[i]].edge == edge; ++i) {
        value = has_inside_ ? value - found_.nodes[nodes[i]].side : 1 - value;
      }
      if (value != 0) cuts_.push_back({{edge.v[0], edge.v[1]}, value});
    }
    for (const Line& line : lines_) {
      const Curve& curve = found_.curves[line.curve];
      for (const std::uint32_t node : {curve.nodes.front(), curve.nodes.back()}) {
        if (found_.nodes[node].is_vertex()) pinched_.push_back(found_.nodes[node].edge.v[0]);
      }
    }
    sort_and_unify(pinched_);
  }

  bool is_cut(std::uint32_t a, std::uint32_t b) const {
    const auto [low, high] = std::minmax(a, b);
    const std::pair<std::uint32_t, std::uint32_t> wanted{low, high};
    const auto at = std::lower_bound(cuts_.begin(), cuts_.end(), wanted, [](const Cut& cut, const auto& key) {
      return std::pair(cut.v[0], cut.v[1]) < key;
    });
    return at != cuts_.end() && at->v[0] == low && at->v[1] == high;
  }
  bool is_pinched(std::uint32_t v) const { return std::binary_search(pinched_.begin(), pinched_.end(), v); }

  /// Joins vertices along edges that are not cut to patches.
  void flood() {
    std::vector<bool> is_cut_vertex(surface_.mesh.vertex_count, false);
    for (const Cut& cut : cuts_) is_cut_vertex[cut.v[0]] = is_cut_vertex[cut.v[1]] = true;
    for (const std::uint32_t v : pinched_) is_cut_vertex[v] = true;
    VertexSets sets(surface_.mesh.vertex_count);
    std::vector<bool> is_used(surface_.mesh.vertex_count, false);
    for (std::uint32_t t = 0; t < surface_.mesh.face_count(); ++t) {
      if (!surface_.has_face(t)) continue;
      const Triangle triangle = surface_.triangle(t);
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t a = triangle.v[i];
        const std::uint32_t b = triangle.v[(i + 1) % 3];
        is_used[a] = true;
        if (is_cut_vertex[a] && is_cut_vertex[b] && is_cut(a, b)) continue;
        if ((is_cut_vertex[a] && is_pinched(a)) || (is_cut_vertex[b] && is_pinched(b))) continue;
        sets.join(a, b);
      }
    }
    patch_.assign(surface_.mesh.vertex_count, kNoPatch);
    std::vector<std::uint32_t> patch_of_root(surface_.mesh.vertex_count, kNoPatch);
    for (std::uint32_t v = 0; v < surface_.mesh.vertex_count; ++v) {
      if (!is_used[v] || is_pinched(v)) continue;
      std::uint32_t& patch = patch_of_root[sets.find(v)];
      if (patch == kNoPatch) {
        patch = static_cast<std::uint32_t>(first_vertex_.size());
        first_vertex_.push_back(v);
      }
      patch_[v] = patch;
    }
    is_wrong_.assign(first_vertex_.size(), false);
    is_contradicted_.assign(first_vertex_.size(), false);
    measure_areas();
    list_neighbours();
  }

  void measure_areas() {
    area_.assign(first_vertex_.size(), 0.0);
    for (std::uint32_t t = 0; t < surface_.mesh.face_count(); ++t) {
      if (!surface_.has_face(t)) continue;
      const double third = area_of(surface_, t) / 3.0;
      for (const std::uint32_t v : surface_.triangle(t).v) {
        if (patch_[v] != kNoPatch) area_[patch_[v]] += third;
      }
    }
  }

  /// Neighbouring patches, behind the cuts between them.
  void list_neighbours() {
    for (const Cut& cut : cuts_) {
      const std::uint32_t a = patch_[cut.v[0]];
      const std::uint32_t b = patch_[cut.v[1]];
      if (a == kNoPatch || b == kNoPatch || a == b) continue;
      neighbours_.push_back({a, b, cut.value});
      neighbours_.push_back({b, a, -cut.value});
    }
    std::sort(neighbours_.begin(), neighbours_.end());
    neighbours_.erase(std::unique(neighbours_.begin(), neighbours_.end()), neighbours_.end());
  }

  /// Calls, for each connected part of the surface, enter(patch) for its first patch, cross(pair, is_new) for each pair
  /// of neighbours, where is_new says that pair.to was not visited before, and leave(patches) in the end.
  template <class Enter, class Cross, class Leave>
  void visit(const Enter& enter, const Cross& cross, const Leave& leave) {
    std::vector<bool> is_seen(first_vertex_.size(), false);
    std::vector<std::uint32_t> connected;
    for (std::uint32_t first = 0; first < first_vertex_.size(); ++first) {
      if (is_seen[first]) continue;
      connected.assign(1, first);
      is_seen[first] = true;
      enter(first);
      for (std::size_t i = 0; i < connected.size(); ++i) {
        const auto from =
            std::lower_bound(neighbours_.begin(), neighbours_.end(), Neighbour{connected[i], 0, INT32_MIN});
        for (auto at = from; at != neighbours_.end() && at->from == connected[i]; ++at) {
          cross(*at, !is_seen[at->to]);
          if (!is_seen[at->to]) connected.push_back(at->to);
          is_seen[at->to] = true;
        }
      }
      leave(connected);
    }
  }

  /// Decides which patches are inside the other surface.
  void wind() {
    std::vector<int> winding(first_vertex_.size(), 0);
    bool is_contradicted = false;
    const Box box = box_of_surface(other_);
    visit(
        [&](std::uint32_t patch) {
          const std::uint32_t v = first_vertex_[patch];
          // The surface has no point in common with the perturbed point outside of its box.
          winding[patch] = contains(box, box_of(surface_.x[v])) ? winding_number(other_, surface_, v) : 0;
          is_contradicted = false;
        },
        [&](const Neighbour& pair, bool is_new) {
          const int there = winding[pair.from] + pair.value;
          if (is_new) winding[pair.to] = there;
          is_contradicted |= winding[pair.to] != there;
        },
        [&](const std::vector<std::uint32_t>& connected) {
          for (const std::uint32_t patch : connected) {
            is_wrong_[patch] = winding[patch] != 0;
            is_contradicted_[patch] = is_contradicted;
          }
        });
  }

  /// Gives neighbouring patches different colours. The colour with the smaller area is wrong; of equal ones, that
  /// without the first patch.
  void colour() {
    std::vector<bool> is_second(first_vertex_.size(), false);
    bool is_contradicted = false;
    visit([&](std::uint32_t) { is_contradicted = false; },
          [&](const Neighbour& pair, bool is_new) {
            if (is_new) is_second[pair.to] = !is_second[pair.from];
            is_contradicted |= is_second[pair.to] == is_second[pair.from];
          },
          [&](const std::vector<std::uint32_t>& connected) {
            double areas[2] = {0, 0};
            for (const std::uint32_t patch : connected) areas[is_second[patch] ? 1 : 0] += area_[patch];
            const bool wrong = areas[1] <= areas[0];
            for (const std::uint32_t patch : connected) {
              is_wrong_[patch] = connected.size() > 1 && is_second[patch] == wrong && !is_contradicted;
              is_contradicted_[patch] = is_contradicted;
            }
          });
  }

  /// The patches at a trace, and whether it divides them.
  struct Bounded {
    std::vector<std::uint32_t> patches;    ///< the patches of its edges' ends
    std::vector<std::uint32_t> separated;  ///< those on either side of it
    bool is_contradicted = false;          ///< some patch is
    bool has_cut = false;                  ///< some edge is cut
  };
  Bounded bounded_by(const Trace& trace) const {
    Bounded bounded;
    for (const std::uint32_t node : trace.nodes) {
      const SurfaceEdge& edge = found_.nodes[node].edge;
      const std::uint32_t a = patch_[edge.v[0]];
      const std::uint32_t b = patch_[edge.v[1]];
      for (const std::uint32_t patch : {a, b}) {
        if (patch != kNoPatch) bounded.patches.push_back(patch);
      }
      if (!is_cut(edge.v[0], edge.v[1])) continue;
      bounded.has_cut = true;
      if (a != b) bounded.separated.insert(bounded.separated.end(), {a, b});
    }
    if (trace.nodes.empty()) {
      for (const std::uint32_t t : trace.triangles) {
        for (const std::uint32_t v : surface_.triangle(t).v) {
          if (patch_[v] != kNoPatch) bounded.patches.push_back(patch_[v]);
        }
      }
    }
    sort_and_unify(bounded.patches);
    sort_and_unify(bounded.separated);
    if (!bounded.separated.empty() && bounded.separated.back() == kNoPatch) bounded.separated.pop_back();
    for (const std::uint32_t patch : bounded.patches) bounded.is_contradicted |= is_contradicted_[patch];
    return bounded;
  }

  void collect(std::vector<FoundRegion>& regions) {
    const std::size_t first = regions.size();
    std::vector<std::uint32_t> region_of(first_vertex_.size(), kNoIndex);
    for (std::uint32_t patch = 0; patch < first_vertex_.size(); ++patch) {
      if (!is_wrong_[patch] || is_contradicted_[patch]) continue;
      region_of[patch] = static_cast<std::uint32_t>(regions.size());
      regions.push_back(new_region(RegionKind::closed));
      regions.back().is_inside = has_inside_;
      regions.back().area = area_[patch];
    }
    fill(regions, region_of);
    for (const Line& line : lines_) add_line(line, regions, region_of);
    for (std::size_t i = first; i < regions.size(); ++i) {
      sort_and_unify(regions[i].vertices);
      sort_and_unify(regions[i].triangles);
      sort_and_unify(regions[i].curves);
      sort_and_unify(regions[i].opposite);
    }
    std::stable_sort(regions.begin() + static_cast<std::ptrdiff_t>(first), regions.end(),
                     [](const FoundRegion& a, const FoundRegion& b) { return a.triangles < b.triangles; });
  }

  FoundRegion new_region(RegionKind kind) const {
    FoundRegion region;
    region.surface = surface_.number;
    region.other = other_.number;
    region.kind = kind;
    return region;
  }

  void fill(std::vector<FoundRegion>& regions, const std::vector<std::uint32_t>& region_of) const {
    for (std::uint32_t v = 0; v < surface_.mesh.vertex_count; ++v) {
      if (patch_[v] != kNoPatch && region_of[patch_[v]] != kNoIndex)
        regions[region_of[patch_[v]]].vertices.push_back(v);
    }
    for (std::uint32_t t = 0; t < surface_.mesh.face_count(); ++t) {
      if (!surface_.has_face(t)) continue;
      for (const std::uint32_t v : surface_.triangle(t).v) {
        if (patch_[v] != kNoPatch && region_of[patch_[v]] != kNoIndex) {
          regions[region_of[patch_[v]]].triangles.push_back(t);
        }
      }
    }
  }

  void add_line(const Line& line, std::vector<FoundRegion>& regions, const std::vector<std::uint32_t>& region_of) {
    const Curve& curve = found_.curves[line.curve];
    const Trace& own = trace(line);
    const Trace& opposite = curve.traces[1 - line.line];
    const Bounded bounded = bounded_by(own);
    const auto attach = [&](FoundRegion& region) {
      region.curves.push_back(line.curve);
      region.triangles.insert(region.triangles.end(), own.triangles.begin(), own.triangles.end());
      if (surface_.number == other_.number) {
        region.opposite.insert(region.opposite.end(), opposite.triangles.begin(), opposite.triangles.end());
      }
    };
    const bool encloses_no_vertex = curve.is_closed && !bounded.has_cut;
    bool is_in_region = false;
    for (const std::uint32_t patch : encloses_no_vertex ? bounded.patches : bounded.separated) {
      if (region_of[patch] == kNoIndex) continue;
      FoundRegion& region = regions[region_of[patch]];
      attach(region);
      is_in_region = true;
      if (curve.is_branched || own.ends_within) {
        region.kind = RegionKind::degenerate;
      } else if (own.ends_at_border && region.kind == RegionKind::closed) {
        region.kind = RegionKind::loop_with_border;
      }
    }
    if (is_in_region) return;
    if (bounded.is_contradicted || curve.is_branched) {
      regions.push_back(new_region(RegionKind::degenerate));
    } else if (encloses_no_vertex) {
      regions.push_back(new_region(RegionKind::closed));
      regions.back().is_inside = has_inside_;
      regions.back().area = enclosed_area(curve);
    } else {
      regions.push_back(new_region(RegionKind::open));
    }
    FoundRegion& region = regions.back();
    attach(region);
    if (region.kind == RegionKind::closed) return;
    for (const std::uint32_t node : own.nodes) {
      region.vertices.insert(region.vertices.end(), found_.nodes[node].edge.v, found_.nodes[node].edge.v + 2);
    }
    for (const std::uint32_t t : pierced_triangles(opposite)) {
      const Triangle triangle = surface_.triangle(t);
      region.vertices.insert(region.vertices.end(), triangle.v, triangle.v + 3);
    }
  }

  std::vector<std::uint32_t> pierced_triangles(const Trace& opposite) const {
    std::vector<std::uint32_t> pierced;
    for (const std::uint32_t node : opposite.nodes) pierced.push_back(found_.nodes[node].triangle.triangle);
    return pierced;
  }

  double enclosed_area(const Curve& curve) const {
    const Vec3d from = point_of(found_.nodes[curve.nodes.front()], surfaces_);
    Vec3d sum{0, 0, 0};
    for (std::size_t i = 1; i + 1 < curve.nodes.size(); ++i) {
      sum = sum + cross(point_of(found_.nodes[curve.nodes[i]], surfaces_) - from,
                        point_of(found_.nodes[curve.nodes[i + 1]], surfaces_) - from);
    }
    return 0.5 * std::sqrt(squared_norm(sum));
  }

  struct Neighbour {
    std::uint32_t from, to;
    std::int32_t value;

    friend bool operator==(const Neighbour&, const Neighbour&) = default;
    friend bool operator<(const Neighbour& a, const Neighbour& b) {
      return std::tie(a.from, a.to, a.value) < std::tie(b.from, b.to, b.value);
    }
  };

  Span<const Surface> surfaces_;
  const IntersectionCurves& found_;
  const Surface& surface_;
  const Surface& other_;
  bool has_inside_;
  std::vector<Line> lines_;
  std::vector<Cut> cuts_;               ///< ascending
  std::vector<std::uint32_t> pinched_;  ///< vertices at which curves end, ascending
  std::vector<std::uint32_t> patch_;    ///< of each vertex
  std::vector<Neighbour> neighbours_;   ///< ascending
  // The following have a value for each patch:
  std::vector<std::uint32_t> first_vertex_;
  std::vector<double> area_;
  std::vector<bool> is_wrong_, is_contradicted_;
};

/// A trace of a curve, and the surfaces that it belongs to.
struct PairLine {
  SurfacePair pair;
  std::uint32_t curve, line;

  friend bool operator<(const PairLine& a, const PairLine& b) {
    return std::tie(a.pair, a.curve, a.line) < std::tie(b.pair, b.curve, b.line);
  }
};

}  // namespace

std::vector<FoundRegion> find_regions(Span<const Surface> surfaces, const IntersectionCurves& found,
                                      Span<const SurfacePair> without_curves) {
  constexpr std::uint32_t kNoCurve = kNoIndex;
  std::vector<PairLine> lines;
  for (const SurfacePair& pair : without_curves) lines.push_back({pair, kNoCurve, 0});
  for (std::uint32_t c = 0; c < found.curves.size(); ++c) {
    const Curve& curve = found.curves[c];
    lines.push_back({{curve.surface_a, curve.surface_b}, c, 0});
    lines.push_back({{curve.surface_b, curve.surface_a}, c, 1});
  }
  std::sort(lines.begin(), lines.end());
  std::vector<FoundRegion> regions;
  for (std::size_t i = 0; i < lines.size();) {
    const SurfacePair pair = lines[i].pair;
    PairRegions of_pair(surfaces, found, pair);
    for (; i < lines.size() && lines[i].pair == pair; ++i) {
      if (lines[i].curve != kNoCurve) of_pair.add_trace(lines[i].curve, lines[i].line);
    }
    of_pair.find(regions);
  }
  return regions;
}

}  // namespace softcd::detail

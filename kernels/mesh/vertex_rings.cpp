#include "softcd/mesh/vertex_rings.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <numeric>

#include "softcd/core/parallel.hpp"

namespace softcd {
namespace {

constexpr std::uint32_t kVerticesAtOnce = 4096;

/// Returns whether no triangle has the edge any more; see ChangingMesh.
bool is_free(const Edge& edge) {
  return edge.v[0] == edge.v[1];
}

/// The neighbours of each vertex along its edges, counted from the mesh's first vertex.
class Adjacency {
 public:
  explicit Adjacency(const MeshView& mesh) : first_(mesh.vertex_count + std::size_t{1}, 0) {
    for (const Edge& edge : mesh.edges) {
      if (is_free(edge)) continue;
      for (const std::uint32_t v : edge.v) ++first_[v - mesh.first_vertex + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    vertices_.resize(first_.back());
    std::vector<std::uint64_t> next(first_.begin(), first_.end() - 1);
    for (const Edge& edge : mesh.edges) {
      if (is_free(edge)) continue;
      const std::uint32_t a = edge.v[0] - mesh.first_vertex;
      const std::uint32_t b = edge.v[1] - mesh.first_vertex;
      vertices_[next[a]++] = b;
      vertices_[next[b]++] = a;
    }
  }

  Span<const std::uint32_t> of(std::uint32_t v) const {
    return {vertices_.data() + first_[v], static_cast<std::size_t>(first_[v + 1] - first_[v])};
  }

 private:
  std::vector<std::uint64_t> first_;
  std::vector<std::uint32_t> vertices_;
};

/// The rings around a run of vertices.
struct Part {
  std::vector<std::uint64_t> counts;
  std::vector<std::uint32_t> vertices;
};

/// Finds the rings of one vertex after the other by breadth-first search.
class RingFinder {
 public:
  RingFinder(const Adjacency& adjacency, std::uint32_t edge_count) : adjacency_(adjacency), edge_count_(edge_count) {}

  void add(std::uint32_t v, Part& part) {
    reached_.assign(1, v);
    outermost_ = reached_;
    for (std::uint32_t edge = 0; edge < edge_count_ && !outermost_.empty(); ++edge) advance();
    part.counts.push_back(reached_.size() - 1);
    std::copy_if(reached_.begin(), reached_.end(), std::back_inserter(part.vertices),
                 [v](std::uint32_t w) { return w != v; });
  }

 private:
  /// Adds the next ring. Keeps both lists sorted.
  void advance() {
    around_.clear();
    for (const std::uint32_t v : outermost_) {
      const Span<const std::uint32_t> next = adjacency_.of(v);
      around_.insert(around_.end(), next.begin(), next.end());
    }
    std::sort(around_.begin(), around_.end());
    around_.erase(std::unique(around_.begin(), around_.end()), around_.end());
    outermost_.clear();
    std::set_difference(around_.begin(), around_.end(), reached_.begin(), reached_.end(),
                        std::back_inserter(outermost_));
    around_.clear();
    std::merge(reached_.begin(), reached_.end(), outermost_.begin(), outermost_.end(), std::back_inserter(around_));
    reached_.swap(around_);
  }

  const Adjacency& adjacency_;
  std::uint32_t edge_count_;
  std::vector<std::uint32_t> reached_, outermost_, around_;
};

}  // namespace

VertexRings vertex_rings(const MeshView& mesh, std::uint32_t edge_count) {
  const Adjacency adjacency(mesh);
  std::vector<Part> parts((mesh.vertex_count + kVerticesAtOnce - 1) / kVerticesAtOnce);
  parallel::for_each(parts.size(), [&](std::size_t part) {
    const auto begin = static_cast<std::uint32_t>(part) * kVerticesAtOnce;
    const std::uint32_t end = std::min(begin + kVerticesAtOnce, mesh.vertex_count);
    RingFinder finder(adjacency, edge_count);
    for (std::uint32_t v = begin; v < end; ++v) finder.add(v, parts[part]);
  });
  VertexRings rings;
  rings.begin.assign(1, 0);
  for (const Part& part : parts) {
    for (const std::uint64_t count : part.counts) rings.begin.push_back(rings.begin.back() + count);
    for (const std::uint32_t v : part.vertices) rings.vertices.push_back(mesh.first_vertex + v);
  }
  return rings;
}

}  // namespace softcd

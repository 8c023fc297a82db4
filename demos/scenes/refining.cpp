#include "scenes/refining.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <tuple>

namespace softcd::demo {
namespace {

using Edge = std::pair<int, int>;

constexpr btScalar kRefiningHeight = 3;
constexpr btScalar kRefiningRadius = btScalar(0.7);
constexpr btScalar kFold = btScalar(0.35);  // radians between triangles
constexpr btScalar kRefiningShortestInCells = btScalar(0.45);
constexpr std::size_t kMostAtOnce = 60;

/// The triangles beside each edge, valid as long as the cloth does not change.
class Neighbours {
 public:
  explicit Neighbours(const btSoftBody& cloth) : cloth_(cloth) {
    for (int f = 0; f < cloth.m_faces.size(); ++f) {
      for (int side = 0; side < 3; ++side) {
        auto& faces = faces_.try_emplace(edge_of(f, side), Faces{-1, -1}).first->second;
        faces[faces[0] < 0 ? 0 : 1] = f;
      }
    }
  }

  /// Returns the longest edges of the triangles beside sharp folds. If the triangle on the other side of an edge has a
  /// longer edge, that one is taken instead, and so on, until an edge is the longest of both its triangles. This keeps
  /// triangles from getting thin.
  std::set<Edge> to_be_halved(btScalar shortest) const {
    std::set<Edge> edges;
    for (const auto& [edge, faces] : faces_) {
      if (faces[1] < 0 || normal(faces[0]).dot(normal(faces[1])) > btCos(kFold)) continue;
      for (const int face : faces) {
        const Edge longest = longest_around(face);
        if (length(longest) > shortest && edges.size() < kMostAtOnce) edges.insert(longest);
      }
    }
    return edges;
  }

 private:
  using Faces = std::array<int, 2>;  // -1: there is none

  int node(int face, int corner) const {
    return static_cast<int>(cloth_.m_faces[face].m_n[corner % 3] - &cloth_.m_nodes[0]);
  }
  Edge edge_of(int face, int side) const { return std::minmax(node(face, side), node(face, side + 1)); }
  btScalar length(const Edge& edge) const {
    return (cloth_.m_nodes[edge.first].m_x - cloth_.m_nodes[edge.second].m_x).length();
  }
  btVector3 normal(int face) const {
    const auto& n = cloth_.m_faces[face].m_n;
    return btCross(n[1]->m_x - n[0]->m_x, n[2]->m_x - n[0]->m_x).safeNormalize();
  }
  /// Returns the longest edge. Of equal ones it always returns the same, so that longest_around() ends.
  Edge longest(int face) const {
    const auto key = [&](const Edge& edge) { return std::tuple(length(edge), edge); };
    return std::max({edge_of(face, 0), edge_of(face, 1), edge_of(face, 2)},
                    [&](const Edge& a, const Edge& b) { return key(a) < key(b); });
  }
  Edge longest_around(int face) const {
    while (true) {
      const Edge edge = longest(face);
      const Faces& faces = faces_.at(edge);
      const int across = faces[0] == face ? faces[1] : faces[0];
      if (across < 0 || longest(across) == edge) return edge;
      face = across;
    }
  }

  const btSoftBody& cloth_;
  std::map<Edge, Faces> faces_;
};

/// Adds a node at the middle of the edge, with the mean velocity of its ends and the mass of the lighter one. Returns
/// its index.
int add_middle(btSoftBody& cloth, const Edge& edge) {
  const btSoftBody::Node a = cloth.m_nodes[edge.first];
  const btSoftBody::Node b = cloth.m_nodes[edge.second];
  const btScalar inverse_mass = btMax(a.m_im, b.m_im);
  cloth.appendNode((a.m_x + b.m_x) / 2, inverse_mass > 0 ? 1 / inverse_mass : 0);
  btSoftBody::Node& middle = cloth.m_nodes[cloth.m_nodes.size() - 1];
  middle.m_q = (a.m_q + b.m_q) / 2;
  middle.m_v = (a.m_v + b.m_v) / 2;
  return cloth.m_nodes.size() - 1;
}

/// Splits the link a-b and every triangle beside it in two, with a link between the halves of each triangle.
void halve(btSoftBody& cloth, const Edge& edge) {
  btSoftBody::Node* const middle = &cloth.m_nodes[add_middle(cloth, edge)];
  const btSoftBody::Node* const a = &cloth.m_nodes[edge.first];
  const btSoftBody::Node* const b = &cloth.m_nodes[edge.second];
  const auto is_edge = [&](const btSoftBody::Node* from, const btSoftBody::Node* to) {
    return (from == a && to == b) || (from == b && to == a);
  };
  for (int l = cloth.m_links.size() - 1; l >= 0; --l) {
    if (!is_edge(cloth.m_links[l].m_n[0], cloth.m_links[l].m_n[1])) continue;
    cloth.appendLink(l);
    cloth.m_links[l].m_n[1] = middle;
    cloth.m_links[cloth.m_links.size() - 1].m_n[0] = middle;
  }
  for (int f = cloth.m_faces.size() - 1; f >= 0; --f) {
    for (int from = 0; from < 3; ++from) {
      const int to = (from + 1) % 3;
      if (!is_edge(cloth.m_faces[f].m_n[from], cloth.m_faces[f].m_n[to])) continue;
      cloth.appendFace(f);
      cloth.m_faces[f].m_n[to] = middle;
      cloth.m_faces[cloth.m_faces.size() - 1].m_n[from] = middle;
      cloth.appendLink(middle, cloth.m_faces[f].m_n[(from + 2) % 3]);
      break;
    }
  }
}

}  // namespace

Refining::Refining(const SceneOptions& options)
    : ChangingCloth(options, {4, kRefiningHeight, false,
                              btVector3(0, kRefiningHeight - kRefiningRadius - btScalar(0.2), 0), kRefiningRadius}) {}

std::vector<Refining::Edge> Refining::edges_to_change() const {
  const std::set<Edge> edges = Neighbours(cloth()).to_be_halved(kRefiningShortestInCells * spacing());
  return {edges.begin(), edges.end()};
}

bool Refining::change_at(const Edge& edge) {
  halve(cloth(), edge);
  return true;
}

View Refining::view() const {
  return {btVector3(btScalar(4.3), btScalar(5.0), btScalar(5.9)), btVector3(0, btScalar(1.8), 0)};
}

}  // namespace softcd::demo

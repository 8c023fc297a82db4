#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "mesh_generators.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/mesh/topology.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/grid_parameters.hpp"

namespace softcd::test {

/// Replaces a backend's list, with unlimited capacity.
template <class T>
struct Collector {
  /// Places for as many items as were announced.
  class Room {
   public:
    Room(Collector& collector, std::uint32_t count) : collector_(collector), left_(count) {}
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;
    ~Room() { EXPECT_EQ(left_, 0U) << "fewer items than announced"; }

    void put(const T& item) {
      ASSERT_GT(left_, 0U) << "more items than announced";
      --left_;
      collector_.items.push_back(item);
    }

   private:
    Collector& collector_;
    std::uint32_t left_;
  };

  std::vector<T> items;

  void push(const T& item) { items.push_back(item); }
  Room allocate(std::uint32_t count) { return Room(*this, count); }
};

struct HostBody {
  Mesh mesh;
  Positions3 x_t0;  ///< empty: at rest
  float margin = 0.0F;
  bool self_collision = true;
  bool vertex_triangle = true;
  bool edge_edge = true;
};

/// The detector's input for the stages, made simply. Bodies are concatenated, and every body may touch every other.
/// Coordinates are converted to float; the tests' are on a grid.
class HostScene {
 public:
  HostScene(std::vector<HostBody> bodies, bool continuous) : bodies_(std::move(bodies)), continuous_(continuous) {
    for (const HostBody& body : bodies_) append(body);
    for (std::uint32_t a = 0; a < bodies_.size(); ++a) {
      partner_begin_.push_back(partners_.size());
      for (std::uint32_t b = 0; b < bodies_.size(); ++b) {
        if (a != b || bodies_[a].self_collision) partners_.push_back(b);
      }
    }
    partner_begin_.push_back(partners_.size());
  }

  SceneView view() const {
    SceneView view;
    view.x_t0 = x_t0_.data();
    view.x_t1 = x_t1_.data();
    view.triangles = triangles_.data();
    view.triangle_edges = triangle_edges_.data();
    view.edges = edges_.data();
    view.ownership = ownership_.data();
    view.triangle_body = triangle_body_.data();
    view.vertex_body = vertex_body_.data();
    view.bodies = scene_bodies_.data();
    view.partner_begin = partner_begin_.data();
    view.partners = partners_.data();
    view.vertex_count = static_cast<std::uint32_t>(x_t1_.size());
    view.triangle_count = static_cast<std::uint32_t>(triangles_.size());
    view.edge_count = static_cast<std::uint32_t>(edges_.size());
    view.body_count = static_cast<std::uint32_t>(bodies_.size());
    view.is_swept = continuous_;
    view.summarize_pairs(partner_begin_, partners_);
    return view;
  }

  SceneView view_with_patches() const {
    SceneView scene = view();
    scene.patch_triangles = patch_triangles_.data();
    scene.patch_count = static_cast<std::uint32_t>(patch_triangles_.size() / kPatchSize);
    return scene;
  }

  std::vector<Ownership>& ownership() { return ownership_; }
  softcd::SceneBody& body(std::size_t i) { return scene_bodies_[i]; }

 private:
  static Vec3f to_float(Vec3d p) { return vec3_cast<float>(p); }

  void append(const HostBody& body) {
    constexpr float kEverywhere = 3e38F;
    const auto first_vertex = static_cast<std::uint32_t>(x_t1_.size());
    const auto first_triangle = static_cast<std::uint32_t>(triangles_.size());
    const auto first_edge = static_cast<std::uint32_t>(edges_.size());
    const auto id = static_cast<std::uint32_t>(scene_bodies_.size());
    const Topology topology =
        build_topology(body.mesh.triangles, static_cast<std::uint32_t>(body.mesh.positions.size()));
    for (const Vec3d& p : body.mesh.positions) x_t1_.push_back(to_float(p));
    for (const Vec3d& p : body.x_t0.empty() ? body.mesh.positions : body.x_t0) x_t0_.push_back(to_float(p));
    for (const Triangle& t : topology.triangles) triangles_.push_back(shifted(t, first_vertex));
    for (const std::uint32_t t : topology.patches.triangles) {
      patch_triangles_.push_back(t == kNoIndex ? kNoIndex : t + first_triangle);
    }
    for (TriangleEdges edges : topology.triangle_edges) {
      for (std::uint32_t& e : edges.e) e = e == kNoIndex ? e : e + first_edge;
      triangle_edges_.push_back(edges);
    }
    for (const Edge& e : topology.edges) edges_.push_back({{e.v[0] + first_vertex, e.v[1] + first_vertex}});
    ownership_.insert(ownership_.end(), topology.ownership.begin(), topology.ownership.end());
    triangle_body_.resize(triangles_.size(), id);
    vertex_body_.resize(x_t1_.size(), id);
    scene_bodies_.push_back({id,
                             first_vertex,
                             first_triangle,
                             first_edge,
                             body.margin,
                             body.vertex_triangle,
                             body.edge_edge,
                             /*lists_neighbours=*/false,
                             {{-kEverywhere, -kEverywhere, -kEverywhere}, {kEverywhere, kEverywhere, kEverywhere}}});
  }

  static Triangle shifted(Triangle t, std::uint32_t offset) {
    for (std::uint32_t& v : t.v) v += offset;
    return t;
  }

  std::vector<HostBody> bodies_;
  bool continuous_;
  std::vector<Vec3f> x_t0_, x_t1_;
  std::vector<Triangle> triangles_;
  std::vector<TriangleEdges> triangle_edges_;
  std::vector<Edge> edges_;
  std::vector<Ownership> ownership_;
  std::vector<std::uint32_t> triangle_body_, vertex_body_, partners_, patch_triangles_;
  std::vector<std::uint64_t> partner_begin_;
  std::vector<softcd::SceneBody> scene_bodies_;
};

/// Returns the grid of a scene with so many triangles that large ones are split.
inline GridParameters grid_of(float cell_size) {
  GridParameters grid{};
  grid.active_triangles = grid.active_elements = 1U << 30;
  grid.cell_size = cell_size;
  grid.inverse_cell_size = 1.0F / cell_size;
  return grid;
}

/// The volumes of a scene, by the first stage.
struct HostVolumes {
  std::vector<Kdop18> volumes;
  std::vector<EndVolumes> end_volumes;
  std::vector<TriangleShape> shapes;

  explicit HostVolumes(const SceneView& scene)
      : volumes(scene.element_count()), end_volumes(scene.element_count()), shapes(scene.element_count()) {
    const BoundTriangle bound{scene, volumes.data(), end_volumes.data(), shapes.data()};
    for (std::uint32_t t = 0; t < scene.triangle_count; ++t) bound(t);
  }
};

}  // namespace softcd::test

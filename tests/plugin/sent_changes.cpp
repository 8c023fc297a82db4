#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "expectations.hpp"
#include "forwarding_detector.hpp"
#include "mesh_generators.hpp"
#include "query_core.hpp"
#include "random.hpp"
#include "scene_parts.hpp"
#include "selected_detector.hpp"

// A device receives the changed parts of a scene: all of them, and little more.
namespace softcd::test {
namespace {

/// A copy of an array that receives ranges.
template <class T>
class Copy {
 public:
  void follow(Span<const T> values, const std::vector<Range>& ranges) {
    T garbage;
    std::memset(&garbage, 0xCD, sizeof(T));
    copy_.resize(values.size(), garbage);
    for (const Range& range : ranges) {
      ASSERT_LE(range.end, values.size());
      if (range.begin == range.end) continue;
      std::memcpy(copy_.data() + range.begin, values.data() + range.begin, (range.end - range.begin) * sizeof(T));
      sent_ += range.end - range.begin;
    }
    EXPECT_TRUE(copy_.empty() || std::memcmp(copy_.data(), values.data(), copy_.size() * sizeof(T)) == 0);
  }
  /// Returns the number of elements received since the last call.
  std::uint64_t sent() { return std::exchange(sent_, 0); }

 private:
  std::vector<T> copy_;
  std::uint64_t sent_ = 0;
};

struct Sent {
  Copy<Triangle> triangles;
  Copy<Edge> edges;
  Copy<std::uint64_t> vertex_triangle_neighbours, edge_edge_neighbours;
  Copy<TriangleEdges> triangle_edges;
  Copy<Ownership> ownership;
  Copy<std::uint32_t> triangle_body, vertex_body;

  void follow(const SceneArrays& scene, const SceneChanges& changes) {
    triangles.follow(scene.triangles, changes.triangles);
    triangle_edges.follow(scene.triangle_edges, changes.triangles);
    triangle_body.follow(scene.triangle_body, changes.triangles);
    std::vector<Range> of_ownership = changes.triangles;
    of_ownership.insert(of_ownership.end(), changes.ownership.begin(), changes.ownership.end());
    ownership.follow(scene.ownership, of_ownership);
    edges.follow(scene.edges, changes.edges);
    vertex_body.follow(scene.vertex_body, changes.vertices);
    vertex_triangle_neighbours.follow(scene.vertex_triangle_neighbours, changes.vertex_triangle_neighbours);
    edge_edge_neighbours.follow(scene.edge_edge_neighbours, changes.edge_edge_neighbours);
  }
};

/// Computes on the CPU.
class CopyingDevice final : public ForwardingDetector {
 public:
  explicit CopyingDevice(Sent& sent) : sent_(sent) {}

  void set_scene(const SceneArrays& scene, const SceneChanges& changes) override {
    sent_.follow(scene, changes);
    ForwardingDetector::set_scene(scene, changes);
  }

 private:
  Sent& sent_;
};

class SentChanges : public testing::Test {
 protected:
  void detect() { query_.wait(query_.start(Pairs::all)); }
  BodyId add(const SceneBody& body) {
    const BodyId id = scene_->add_body(desc_of(body));
    scene_->set_positions(id, body.x_t0, body.x_t1);
    return id;
  }
  void change(BodyId id, const SceneBody& body, const std::vector<std::uint32_t>& changed) {
    scene_->update_body(id, desc_of(body), changed);
    scene_->set_positions(id, body.x_t0, body.x_t1);
  }

  Sent sent_;
  std::shared_ptr<detail::SceneCore> scene_ = std::make_shared<detail::SceneCore>(
      SceneOptions{Backend::cuda}, LogCallback(),
      DetectorFactories{make_cpu_detector, [this] { return std::make_unique<CopyingDevice>(sent_); }, ""});
  detail::QueryCore query_{scene_, {}};
};

TEST_F(SentChanges, are_all_that_is_needed) {
  Random random(1);
  std::vector<SceneBody> bodies(3, still(crumpled_cloth(12, 10, 0.25, 0.3, 7), everything(0.01F)));
  std::vector<BodyId> ids;
  for (const SceneBody& body : bodies) ids.push_back(add(body));
  for (int step = 0; step < 60 && !HasFailure(); ++step) {
    SCOPED_TRACE(step);
    for (int i = step % 3; i >= 0; --i) {
      const std::uint32_t b = random.below(3);
      SceneBody& body = bodies[b];
      const auto all = static_cast<std::uint32_t>(body.triangles.size());
      const std::vector<std::uint32_t> changed{random.below(all / 2), random.below(all / 2)};
      std::swap(body.triangles[changed[0]].v[0], body.triangles[changed[1]].v[0]);
      if (random.chance(0.5)) {
        body.triangles.resize(all - random.below(4));
      } else {
        body.triangles.insert(body.triangles.end(), random.below(12), {{random.below(9), 5, 6}});
      }
      change(ids[b], body, changed);
    }
    detect();
  }
}

TEST_F(SentChanges, are_little_more) {
  SceneBody body = still(grid_cloth(200, 200, 0.1), everything());
  const BodyId id = add(body);
  const auto swap_corners = [&] {
    std::swap(body.triangles[100].v[0], body.triangles[60'000].v[0]);
    change(id, body, {100, 60'000});
    detect();
  };
  detect();
  const std::uint64_t all = sent_.vertex_triangle_neighbours.sent();
  swap_corners();  // with spare capacity
  sent_.triangles.sent();
  sent_.edges.sent();
  sent_.vertex_triangle_neighbours.sent();
  sent_.edge_edge_neighbours.sent();
  swap_corners();
  EXPECT_LT(sent_.triangles.sent(), body.triangles.size() / 10);
  EXPECT_LT(sent_.edges.sent(), body.triangles.size() / 10);
  EXPECT_LT(sent_.vertex_triangle_neighbours.sent(), all / 10);
  EXPECT_LT(sent_.edge_edge_neighbours.sent(), all / 10);
}

}  // namespace
}  // namespace softcd::test

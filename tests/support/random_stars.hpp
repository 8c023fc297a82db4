#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "random.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/mesh/topology.hpp"
#include "softcd/stages/vertex_stars.hpp"

namespace softcd::test {

/// A scene of one body for each star: random fans, open and closed, flat and folded, that turn up to twice around their
/// vertex and move.
struct RandomStars {
  std::vector<Vec3f> x_t0, x_t1;
  std::vector<std::uint32_t> vertex_body;
  std::vector<SceneBody> bodies;
  std::vector<VertexStar> stars;
  std::vector<Topology> topologies;  ///< of each star, numbered from its centre
  SceneView view;

  RandomStars(Random& random, int count, double size) {
    for (int i = 0; i < count; ++i) add(random, size);
    view.x_t0 = x_t0.data();
    view.x_t1 = x_t1.data();
    view.vertex_body = vertex_body.data();
    view.bodies = bodies.data();
    view.vertex_count = static_cast<std::uint32_t>(x_t1.size());
    view.body_count = static_cast<std::uint32_t>(bodies.size());
    view.is_swept = random.chance(0.6);
    view.contact_rule = !view.is_swept && random.chance(0.3) ? ContactRule::slab : ContactRule::distance;
    if (!view.is_swept) view.x_t0 = view.x_t1;
  }

  /// Returns for each vertex whether it is the centre of a star that is spread out. `run` runs the stage.
  template <class Run>
  std::vector<std::uint8_t> spread(const Run& run) const {
    std::vector<std::uint8_t> vertices(x_t1.size(), 2);
    run(TestStar{view, stars.data(), {vertices.data(), nullptr, nullptr}}, static_cast<std::uint32_t>(stars.size()));
    return vertices;
  }

 private:
  void add(Random& random, double size) {
    const bool is_closed = random.chance(0.6);
    const std::uint32_t most = kMostTrianglesOfStar + (random.chance(0.05) ? 2U : 0U);
    const std::uint32_t triangle_count = is_closed ? 3 + random.below(most - 2) : 1 + random.below(most);
    const std::uint32_t ring_count = triangle_count + (is_closed ? 0U : 1U);
    const auto first = static_cast<std::uint32_t>(x_t1.size());
    const double turn = is_closed ? (random.chance(0.2) ? 4.0 : 2.0) * 3.14159265358979 : random.uniform(0.3, 11.0);
    const double noise = random.chance(0.5) ? random.uniform(0.0, 0.3) : random.uniform(0.0, 1.0);
    const double motion = random.chance(0.3) ? 0.0 : random.uniform(0.0, 1.0);
    const Vec3d shift = random_vector(random, 3.0);
    const auto add_vertex = [&](Vec3d x) {
      x = x + random_vector(random, noise);
      x_t1.push_back(vec3_cast<float>(size * x));
      x_t0.push_back(vec3_cast<float>(size * (x + shift + random_vector(random, motion))));
      vertex_body.push_back(static_cast<std::uint32_t>(bodies.size()));
    };
    add_vertex({0, 0, 0});
    for (std::uint32_t i = 0; i < ring_count; ++i) {
      const double angle = turn * i / triangle_count;
      add_vertex({std::cos(angle), std::sin(angle), 0.0});
    }
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < triangle_count; ++i) triangles.push_back({{0, i + 1, (i + 1) % ring_count + 1}});
    topologies.push_back(build_topology(triangles, ring_count + 1));
    VertexStar star = star_of(0, triangles);
    star.centre += first;
    for (std::uint32_t& v : star.ring) v += v == kNoIndex ? 0U : first;
    stars.push_back(star);
    SceneBody body{};
    body.first_vertex = first;
    body.margin = random.chance(0.3) ? 0.0F : static_cast<float>(size * random.uniform(0.0, 0.3));
    body.is_rounded = random.chance(0.2);
    body.has_stars = true;
    bodies.push_back(body);
  }

  static Vec3d random_vector(Random& random, double size) {
    return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
  }
};

}  // namespace softcd::test

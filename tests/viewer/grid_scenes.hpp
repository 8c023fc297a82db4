#pragma once

#include <vector>

#include "scene.hpp"
#include "viewer/detection_grid.hpp"

namespace softcd::demo {

inline PipelineOptions on_cpu(Detection detection) {
  PipelineOptions options;
  options.backend = Backend::cpu;
  options.detection = detection;
  return options;
}

/// Returns the scene's bodies, which refer to the scene.
inline std::vector<GridBody> grid_bodies(const test::Scene& scene) {
  std::vector<GridBody> bodies;
  for (const test::SceneBody& body : scene) {
    const auto vertex_count = static_cast<std::uint32_t>(body.x_t1.size());
    bodies.push_back({{body.triangles, vertex_count, body.settings}, body.x_t0, body.x_t1});
  }
  return bodies;
}

/// Returns a scene of mostly small triangles; a few are a hundred times larger and are split.
inline test::Scene uneven_soup() {
  test::SoupOptions soup;
  soup.triangle_count = 2000;
  soup.largest = 4;
  soup.size_ratio = 200;
  const test::Mesh a = test::triangle_soup(soup);
  soup.seed = 2;
  const test::Mesh b = test::triangle_soup(soup);
  return {test::moving(a, test::jittered(a.positions, 0.1, 1), test::everything(0.01F)),
          test::still(b, test::everything(0.01F))};
}

}  // namespace softcd::demo

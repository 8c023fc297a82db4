#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "paper/detector.hpp"
#include "query_core.hpp"
#include "scene.hpp"

namespace softcd::paper {

/// Returns the result of the first detection with the printed scheme.
inline test::Outcome outcome_by_paper(const test::Scene& bodies, const PipelineOptions& options) {
  const auto scene = std::make_shared<detail::SceneCore>(options, LogCallback(), detector_factories(options));
  detail::QueryCore query(scene, options);
  for (const test::SceneBody& body : bodies) {
    const auto vertex_count = static_cast<std::uint32_t>(body.x_t1.size());
    const BodyId id = scene->add_body({body.triangles, vertex_count, body.settings});
    scene->set_positions(id, body.x_t0, body.x_t1);
  }
  const Span<const Contact> contacts = query.wait(query.start(Pairs::all));
  EXPECT_EQ(query.statistics().backend, options.backend);
  return {{contacts.begin(), contacts.end()}, query.statistics(), query.explain()};
}

}  // namespace softcd::paper

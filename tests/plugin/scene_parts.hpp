#pragma once

#include <cstdint>
#include <vector>

#include "backend_under_test.hpp"
#include "scene.hpp"
#include "softcd/softcd.hpp"

// Makes the content of a softcd::Scene for tests, and reads it.
namespace softcd::test {

inline SceneOptions scene_options(Backend backend = backend_under_test()) {
  SceneOptions options;
  options.backend = backend;
  return options;
}

inline BodyDesc desc_of(const SceneBody& body) {
  return {body.triangles, static_cast<std::uint32_t>(body.x_t1.size()), body.settings, /*rank=*/-1, body.segments};
}

inline QueryOptions looking_for(Detection detection, bool margins = true) {
  QueryOptions options;
  options.accuracy = Accuracy::precise;
  options.detection = detection;
  options.margins = margins;
  return options;
}

/// Copies results, which are valid only until the next question.
template <class T>
std::vector<T> copy_of(Span<const T> answers) {
  return {answers.begin(), answers.end()};
}

}  // namespace softcd::test

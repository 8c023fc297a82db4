#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <exception>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "scene.hpp"
#include "softcd/softcd.hpp"

namespace softcd::test {

/// Calls f(communicator) in a thread for each rank. Returns each rank's error; empty where nothing was thrown.
inline std::vector<std::string> in_ranks(const std::vector<Communicator>& communicators,
                                         const std::function<void(const Communicator&)>& f) {
  std::vector<std::string> problems(communicators.size());
  std::vector<std::thread> threads;
  for (std::size_t rank = 0; rank < communicators.size(); ++rank) {
    threads.emplace_back([&, rank] {
      try {
        f(communicators[rank]);
      } catch (const std::exception& error) {
        problems[rank] = error.what();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  return problems;
}

inline void expect_no_problem(const std::vector<std::string>& problems) {
  for (const std::string& problem : problems) EXPECT_EQ(problem, "");
}

/// One rank's scene and query. The ranks take turns in setting bodies' positions.
class RankScene {
 public:
  RankScene(const Scene& scene, const Communicator& communicator, const PipelineOptions& options)
      : communicator_(communicator), scene_(scene_options(communicator, options)), query_(scene_, options) {
    for (std::size_t i = 0; i < scene.size(); ++i) {
      const auto rank = static_cast<std::int32_t>(i % static_cast<std::size_t>(communicator.size()));
      ids_.push_back(scene_.add_body({scene[i].triangles, static_cast<std::uint32_t>(scene[i].x_t1.size()),
                                      scene[i].settings, rank, scene[i].segments}));
    }
  }

  void set_positions(const Scene& scene) {
    for (std::size_t i = 0; i < scene.size(); ++i) {
      if (is_own(i)) scene_.set_positions(ids_[i], scene[i].x_t0, scene[i].x_t1);
    }
  }
  bool is_own(std::size_t body) const {
    return static_cast<int>(body % static_cast<std::size_t>(communicator_.size())) == communicator_.rank();
  }
  softcd::Scene& scene() { return scene_; }
  Query& query() { return query_; }
  BodyId id(std::size_t body) const { return ids_[body]; }

 private:
  static SceneOptions scene_options(const Communicator& communicator, const PipelineOptions& options) {
    SceneOptions result = options;
    result.communicator = communicator;
    result.max_threads = 1;
    return result;
  }

  Communicator communicator_;
  softcd::Scene scene_;
  Query query_;
  std::vector<BodyId> ids_;
};

}  // namespace softcd::test

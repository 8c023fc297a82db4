#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "scene.hpp"

namespace softcd::test {

/// Where the optional data is, or an empty path: the test then skips.
std::filesystem::path data_folder(const std::string& dataset);
/// What it says then.
std::string missing_data(const std::string& dataset);

/// A pair of frames and, for a list of candidate pairs that holds every colliding one, the exact verdicts.
struct GroundTruth {
  Scene scene;  ///< one body
  std::vector<FeaturePair> listed;
  std::vector<bool> collides;  ///< per listed pair

  std::vector<FeaturePair> colliding() const;  ///< sorted
};

/// The two meshes in frames/ of the folder of a recorded step, by their numbers. Throws demo::MeshError when there are
/// not two.
std::array<std::filesystem::path, 2> frames_of(const std::filesystem::path& step);

/// `step` is the name of a folder with two frames, as cloth-ball and armadillo-rollers. Throws std::runtime_error when
/// a file is not as expected.
GroundTruth read_ground_truth(const std::filesystem::path& ccd_steps, const std::string& step);

/// Every coordinate rounded to float32: what a detector with float coordinates sees.
void round_to_float(Scene& scene);

}  // namespace softcd::test

#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "scene.hpp"

namespace softcd::test {

/// Returns the folder of the optional data, or an empty path: the test then skips.
std::filesystem::path data_folder(const std::string& dataset);
/// Returns the message of a test that skips.
std::string missing_data(const std::string& dataset);

/// A pair of frames, and a list of candidate pairs with exact verdicts. The list has every colliding pair.
struct GroundTruth {
  Scene scene;  ///< one body
  std::vector<FeaturePair> listed;
  std::vector<bool> collides;  ///< per listed pair

  std::vector<FeaturePair> colliding() const;  ///< sorted
};

/// Returns the two meshes in frames/ of the folder of a recorded step, by their numbers. Throws mesh_tools::MeshError
/// when there are not two.
std::array<std::filesystem::path, 2> frames_of(const std::filesystem::path& step);

/// Reads a recorded step. `step` is the name of a folder with two frames, such as cloth-ball and armadillo-rollers.
/// Throws std::runtime_error when a file is not as expected.
GroundTruth read_ground_truth(const std::filesystem::path& ccd_steps, const std::string& step);

/// Rounds every coordinate to float32, as a detector with float coordinates does.
void round_to_float(Scene& scene);

}  // namespace softcd::test

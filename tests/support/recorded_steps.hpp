#pragma once

#include <filesystem>
#include <string>

#include "scene.hpp"

namespace softcd::test {

/// Returns the folder of a step in tests/recorded_steps: t0.ply and t1.ply.
std::filesystem::path recorded_step_folder(const std::string& name);

/// Returns that step: all triangles as one body, which collides with itself. Throws mesh_tools::MeshError where it
/// cannot be read.
Scene recorded_step(const std::string& name);

}  // namespace softcd::test

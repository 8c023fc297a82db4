#include "recorded_steps.hpp"

#include "mesh_tools/mesh_io.hpp"

namespace softcd::test {

std::filesystem::path recorded_step_folder(const std::string& name) {
  return std::filesystem::path(SOFTCD_RECORDED_STEPS) / name;
}

Scene recorded_step(const std::string& name) {
  const std::filesystem::path folder = recorded_step_folder(name);
  const mesh_tools::Mesh start = mesh_tools::read_mesh(folder / "t0.ply");
  const mesh_tools::Mesh end = mesh_tools::read_mesh(folder / "t1.ply");
  return {{start.triangles, start.positions, end.positions, everything()}};
}

}  // namespace softcd::test

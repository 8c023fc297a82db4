#include "ground_truth.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "mesh_tools/mesh_io.hpp"

namespace softcd::test {
namespace {

namespace fs = std::filesystem;

/// Returns the N of boxes/Nvf.json.
std::string number_of(const fs::path& folder) {
  const std::string ending = "vf.json";
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / "boxes")) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(ending)) return name.substr(0, name.size() - ending.size());
  }
  throw std::runtime_error("no " + ending + " in " + (folder / "boxes").string());
}

nlohmann::json read_json(const fs::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot open " + path.string());
  return nlohmann::json::parse(file);
}

/// Returns the data's number of each edge. The data numbers edges by (higher, lower) vertex, contacts by (lower,
/// higher).
std::vector<std::uint32_t> edge_numbers(const std::vector<Edge>& edges) {
  std::vector<std::uint32_t> theirs(edges.size());
  for (std::uint32_t i = 0; i < edges.size(); ++i) theirs[i] = i;
  std::sort(theirs.begin(), theirs.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(edges[a].v[1], edges[a].v[0]) < std::pair(edges[b].v[1], edges[b].v[0]);
  });
  return theirs;
}

}  // namespace

fs::path data_folder(const std::string& dataset) {
  const fs::path folder = fs::path(SOFTCD_DATA_DIR) / dataset;
  return fs::is_directory(folder) ? folder : fs::path();
}

std::string missing_data(const std::string& dataset) {
  return (fs::path(SOFTCD_DATA_DIR) / dataset).string() + " is not there: tests/fetch_data.sh fetches it";
}

std::array<fs::path, 2> frames_of(const fs::path& step) {
  const fs::path folder = step / "frames";
  std::vector<fs::path> frames;
  if (fs::is_directory(folder)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) frames.push_back(entry.path());
  }
  if (frames.size() != 2) throw mesh_tools::MeshError(folder.string() + ": is not a folder of two meshes");
  std::sort(frames.begin(), frames.end(), [](const fs::path& a, const fs::path& b) {
    const std::string p = a.filename().string(), q = b.filename().string();
    return std::pair(p.size(), p) < std::pair(q.size(), q);
  });
  return {frames[0], frames[1]};
}

std::vector<FeaturePair> GroundTruth::colliding() const {
  std::vector<FeaturePair> pairs;
  for (std::size_t i = 0; i < listed.size(); ++i) {
    if (collides[i]) pairs.push_back(listed[i]);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

GroundTruth read_ground_truth(const fs::path& ccd_steps, const std::string& step) {
  const fs::path folder = ccd_steps / step;
  const auto [frame_t0, frame_t1] = frames_of(folder);
  const std::string number = number_of(folder);
  const mesh_tools::Mesh start = mesh_tools::read_mesh(frame_t0);
  const mesh_tools::Mesh end = mesh_tools::read_mesh(frame_t1);
  GroundTruth truth;
  truth.scene.push_back({start.triangles, start.positions, end.positions, everything()});

  const auto vertex_count = static_cast<std::uint32_t>(start.positions.size());
  const std::vector<Edge> edges = edges_of(start.triangles);
  const std::vector<std::uint32_t> ours = edge_numbers(edges);
  const auto first_face = static_cast<std::uint32_t>(vertex_count + edges.size());
  for (const bool is_vf : {true, false}) {
    const std::string name = number + (is_vf ? "vf" : "ee");
    const nlohmann::json pairs = read_json(folder / "boxes" / (name + ".json"));
    const nlohmann::json verdicts = read_json(folder / "mma_bool" / (name + "_mma_bool.json"));
    if (pairs.size() != verdicts.size()) throw std::runtime_error("lists of unequal length for " + name);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto a = pairs[i][0].get<std::uint32_t>();
      const auto b = pairs[i][1].get<std::uint32_t>();
      if (is_vf) {
        truth.listed.push_back({ContactKind::vertex_triangle, 0, a, 0, b - first_face});
      } else {
        const auto [low, high] = std::minmax(ours.at(a - vertex_count), ours.at(b - vertex_count));
        truth.listed.push_back({ContactKind::edge_edge, 0, low, 0, high});
      }
      truth.collides.push_back(verdicts[i].get<bool>());
    }
  }
  return truth;
}

void round_to_float(Scene& scene) {
  // Through memory, because g++ 12 removes double -> float -> double conversions that it has vectorised.
  const auto rounded = [](double x) {
    volatile float narrow = static_cast<float>(x);
    return static_cast<double>(narrow);
  };
  for (SceneBody& body : scene) {
    for (Positions3* x : {&body.x_t0, &body.x_t1}) {
      for (Vec3d& p : *x) p = {rounded(p.x), rounded(p.y), rounded(p.z)};
    }
  }
}

}  // namespace softcd::test

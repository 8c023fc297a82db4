#include "mesh_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <system_error>

#include "sha256.hpp"

namespace softcd::demo {
namespace {

namespace fs = std::filesystem;

bool is_figure(char c) {
  return c >= '0' && c <= '9';
}

/// Cuts a row of digits off the front of `text` and returns it without leading zeros.
std::string_view take_figures(std::string_view& text) {
  const auto end = std::find_if_not(text.begin(), text.end(), is_figure);
  std::string_view figures = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(figures.size());
  figures.remove_prefix(std::min(figures.find_first_not_of('0'), figures.size()));
  return figures;
}

bool is_mesh_name(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".ply" || extension == ".obj" || extension == ".glb";
}

/// Throws MeshError unless softcd compares every triangle. It leaves out triangles with a vertex that is not finite or
/// has a coordinate beyond 1e37 (see Positions).
void require_comparable(const fs::path& file, const mesh_tools::Mesh& mesh) {
  const auto require = [&](bool condition, const std::string& problem) {
    if (!condition) throw mesh_tools::MeshError(fmt::format("{}: {}", file.string(), problem));
  };
  require(!mesh.triangles.empty(), "has no triangles, so there is nothing to prove");
  const auto is_left_out = [](const Vec3d& x) {
    return !(std::abs(x.x) <= 1e37 && std::abs(x.y) <= 1e37 && std::abs(x.z) <= 1e37);
  };
  const auto found = std::find_if(mesh.positions.begin(), mesh.positions.end(), is_left_out);
  require(found == mesh.positions.end(),
          fmt::format("vertex {} is not finite or beyond 1e37; give frames in which every position is a number",
                      found - mesh.positions.begin()));
}

}  // namespace

bool is_before(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a;
  const std::string_view whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (is_figure(a.front()) && is_figure(b.front())) {
      const std::string_view number_a = take_figures(a);
      const std::string_view number_b = take_figures(b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
    } else {
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;  // equal but for leading zeros
}

std::vector<fs::path> files_of(const fs::path& file_or_folder) {
  std::error_code error;
  if (!fs::exists(file_or_folder, error))
    throw mesh_tools::MeshError(fmt::format("{}: does not exist", file_or_folder.string()));
  if (!fs::is_directory(file_or_folder, error)) return {file_or_folder};
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(file_or_folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    if (is_mesh_name(entry->path())) files.push_back(entry->path());
  }
  if (error)
    throw mesh_tools::MeshError(fmt::format("{}: cannot be read: {}", file_or_folder.string(), error.message()));
  if (files.empty()) {
    throw mesh_tools::MeshError(
        fmt::format("{}: has no files with names ending in .ply, .obj or .glb", file_or_folder.string()));
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return is_before(a.filename().string(), b.filename().string());
  });
  return files;
}

void MeshSequence::read_next() {
  const fs::path& path = files_.at(hashes_.size());
  mesh_tools::Mesh mesh;
  std::string hash;
  {
    const std::string content = mesh_tools::read_mesh_content(path);
    hash = sha256(content);
    mesh = mesh_tools::parse_mesh(path, content);
  }
  require_comparable(path, mesh);
  if (!hashes_.empty()) mesh_tools::require_same_topology(current_, files_[hashes_.size() - 1], mesh, path);
  hashes_.push_back(std::move(hash));
  previous_ = std::move(current_);
  current_ = std::move(mesh);
}

}  // namespace softcd::demo

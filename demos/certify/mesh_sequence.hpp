#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mesh_tools/mesh_io.hpp"

namespace softcd::demo {

/// Returns whether name a comes before name b when rows of digits count as numbers: frame9 before frame10.
bool is_before(std::string_view a, std::string_view b);

/// Returns the files that a word of the command line stands for: the file itself, or all meshes of a folder (names that
/// end in .ply, .obj or .glb) in the order of is_before(). Throws MeshError when it does not exist or
/// cannot be read, or the folder has no mesh.
std::vector<std::filesystem::path> files_of(const std::filesystem::path& file_or_folder);

/// The frames of one mesh, of which two are in memory: the last one that was read and the one before it.
class MeshSequence {
 public:
  /// `files` are the frames in order, at least one.
  explicit MeshSequence(std::vector<std::filesystem::path> files) : files_(std::move(files)) {}

  std::size_t size() const { return files_.size(); }
  const std::filesystem::path& file(std::size_t frame) const { return files_[frame]; }
  /// Returns whether the mesh moves.
  bool is_moving() const { return files_.size() > 1; }

  /// Reads the next frame. Throws MeshError, naming the file, when it is not a frame of the same mesh, has no triangle,
  /// or has a position that softcd leaves out because it is not finite.
  void read_next();
  /// Returns the last frame that was read.
  const mesh_tools::Mesh& current() const { return current_; }
  /// Returns the frame before it; the same one where only one was read.
  const mesh_tools::Mesh& previous() const { return hashes_.size() > 1 ? previous_ : current_; }
  /// Returns the SHA-256 of every file that was read.
  const std::vector<std::string>& hashes() const { return hashes_; }

 private:
  std::vector<std::filesystem::path> files_;
  std::vector<std::string> hashes_;
  mesh_tools::Mesh current_, previous_;
};

}  // namespace softcd::demo

#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "scenes/scene.hpp"
#include "video.hpp"
#include "viewer/picture_taker.hpp"

namespace softcd::demo {

/// Names one file for each frame. `target` is a folder, for frame-0000.EXTENSION and so on in it, or a file name in
/// which a row of # stands for the number. Creates the folder.
class FileSequence {
 public:
  FileSequence(const std::string& target, const std::string& extension);

  std::filesystem::path next();

 private:
  std::string before_, after_;
  std::size_t digits_;
  long number_ = 0;
};

/// Writes all bodies as one mesh, and creates the file's folder. Throws MeshError, or std::runtime_error.
void write_mesh(const std::filesystem::path& file, const Scene& scene);

/// Writes pictures or a video of a simulation, and its meshes.
class FrameWriter {
 public:
  /// `pictures` draws the frames, and must outlive the object; it may be null where none are recorded. `record` is as
  /// for FileSequence, or a file name that ends in .mp4; `meshes` is as for FileSequence. Empty: none. Throws
  /// std::runtime_error when a folder cannot be created or a video cannot be encoded.
  FrameWriter(PictureTaker* pictures, const std::string& record, const std::string& meshes, int frames_per_second);

  void write(const Scene& scene);
  /// Ends the output. Call it after the last frame.
  void finish();

 private:
  PictureTaker* picture_taker_;
  std::unique_ptr<Video> video_;
  std::optional<FileSequence> pictures_, meshes_;
};

}  // namespace softcd::demo

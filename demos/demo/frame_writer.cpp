#include "frame_writer.hpp"

#include <fmt/format.h>

#include "mesh_tools/mesh_io.hpp"
#include "png_file.hpp"
#include "scenes/vectors.hpp"

namespace softcd::demo {
namespace {

/// Returns all bodies as one mesh.
mesh_tools::Mesh mesh_of(const Scene& scene) {
  mesh_tools::Mesh mesh;
  for (const Surface& surface : scene.all_surfaces()) {
    const btSoftBody& body = *surface.body;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int i = 0; i < body.m_nodes.size(); ++i) {
      mesh.positions.push_back(to_vec3d(body.m_nodes[i].m_x));
    }
    for (int f = 0; f < body.m_faces.size(); ++f) {
      Triangle triangle{};
      for (int i = 0; i < 3; ++i) {
        triangle.v[i] = first + static_cast<std::uint32_t>(body.m_faces[f].m_n[i] - &body.m_nodes[0]);
      }
      mesh.triangles.push_back(triangle);
    }
  }
  return mesh;
}

}  // namespace

void write_mesh(const std::filesystem::path& file, const Scene& scene) {
  std::filesystem::create_directories(file.parent_path());
  mesh_tools::write_mesh(file, mesh_of(scene));
}

FileSequence::FileSequence(const std::string& target, const std::string& extension) {
  const std::string pattern = target.find('#') == std::string::npos
                                  ? (std::filesystem::path(target) / ("frame-####" + extension)).string()
                                  : target;
  const std::size_t start = pattern.find('#');
  digits_ = std::min(pattern.find_first_not_of('#', start), pattern.size()) - start;
  before_ = pattern.substr(0, start);
  after_ = pattern.substr(start + digits_);
  const std::filesystem::path folder = std::filesystem::path(pattern).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder);
}

std::filesystem::path FileSequence::next() {
  return fmt::format("{}{:0{}}{}", before_, number_++, digits_, after_);
}

FrameWriter::FrameWriter(PictureTaker* pictures, const std::string& record, const std::string& meshes,
                         int frames_per_second)
    : picture_taker_(pictures) {
  if (std::filesystem::path(record).extension() == ".mp4" && record.find('#') == std::string::npos) {
    video_ = std::make_unique<Video>(record, frames_per_second);
  } else if (!record.empty()) {
    pictures_.emplace(record, ".png");
  }
  if (!meshes.empty()) meshes_.emplace(meshes, ".ply");
}

void FrameWriter::write(const Scene& scene) {
  if (video_) video_->add(picture_taker_->take(scene));
  if (pictures_) write_png(pictures_->next(), picture_taker_->take(scene));
  if (meshes_) mesh_tools::write_mesh(meshes_->next(), mesh_of(scene));
}

void FrameWriter::finish() {
  if (video_) video_->finish();
}

}  // namespace softcd::demo

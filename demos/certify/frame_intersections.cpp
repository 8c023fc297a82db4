#include "frame_intersections.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "triangle_meeting.hpp"

namespace softcd::demo {
namespace {

constexpr std::size_t kTrianglesAtOnce = 8192;

struct Box {
  Vec3d lo{std::numeric_limits<double>::max(), std::numeric_limits<double>::max(), std::numeric_limits<double>::max()};
  Vec3d hi{-lo.x, -lo.y, -lo.z};

  void include(const Vec3d& x) {
    lo = {std::min(lo.x, x.x), std::min(lo.y, x.y), std::min(lo.z, x.z)};
    hi = {std::max(hi.x, x.x), std::max(hi.y, x.y), std::max(hi.z, x.z)};
  }
};

/// Returns more than the probe's triangles are off by, see Positions: 2^-20 of the scene's extent, ten times their
/// rounding, and the smallest floats.
double rounding_of(const std::vector<MeshSequence>& meshes) {
  Box scene;
  for (const MeshSequence& mesh : meshes) {
    for (const Mesh* frame : {&mesh.previous(), &mesh.current()}) {
      for (const Vec3d& x : frame->positions) scene.include(x);
    }
  }
  const Vec3d extent = scene.hi - scene.lo;
  return 0x1p-20 * std::max({extent.x, extent.y, extent.z}) + 0x1p-140;
}

ProbeBox box_of(const Mesh& mesh, const Triangle& triangle, double slack) {
  Box box;
  for (const std::uint32_t v : triangle.v) box.include(mesh.positions[v]);
  const Vec3d border{slack, slack, slack};
  return {box.lo - border, box.hi + border};
}

Face face_of(const Mesh& mesh, std::uint64_t first_vertex, std::uint32_t triangle) {
  Face face{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t v = mesh.triangles[triangle].v[i];
    face.v[i] = first_vertex + v;
    face.x[i] = mesh.positions[v];
  }
  return face;
}

}  // namespace

std::vector<TrianglePair> FrameIntersections::find(const std::vector<MeshSequence>& meshes) {
  std::vector<std::uint64_t> first_vertex = {0};
  for (const MeshSequence& mesh : meshes) {
    first_vertex.push_back(first_vertex.back() + mesh.current().positions.size());
  }
  const double slack = rounding_of(meshes);
  const Mesh& mesh = meshes[0].current();
  std::vector<TrianglePair> pairs;
  std::vector<ProbeBox> boxes;
  for (std::size_t begin = 0; begin < mesh.triangles.size(); begin += kTrianglesAtOnce) {
    const std::size_t end = std::min(begin + kTrianglesAtOnce, mesh.triangles.size());
    boxes.clear();
    for (std::size_t t = begin; t < end; ++t) boxes.push_back(box_of(mesh, mesh.triangles[t], slack));
    const AnswerLists<TriangleOverlap> near = probe_.overlaps(Span<const ProbeBox>(boxes));
    for (std::size_t t = begin; t < end; ++t) {
      const auto triangle = static_cast<std::uint32_t>(t);
      const Face face = face_of(mesh, 0, triangle);
      for (const TriangleOverlap& overlap : near[t - begin]) {
        const auto found = std::find(bodies_.begin(), bodies_.end(), overlap.body);
        const auto other = static_cast<std::uint32_t>(found - bodies_.begin());
        if (other == 0 && overlap.triangle <= triangle) continue;
        const Meeting meeting =
            meeting_of(face, face_of(meshes[other].current(), first_vertex[other], overlap.triangle));
        if (meeting == Meeting::apart) continue;
        pairs.push_back({triangle, other, overlap.triangle, meeting == Meeting::through});
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace softcd::demo

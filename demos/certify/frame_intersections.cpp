#include "frame_intersections.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "mesh_tools/triangle_meeting.hpp"

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

/// Returns a bound on the rounding of the probe's positions, see Positions: 2^-20 of the scene's extent, which is ten
/// times that rounding, and the smallest floats.
double rounding_of(const std::vector<MeshSequence>& meshes) {
  Box scene;
  for (const MeshSequence& mesh : meshes) {
    for (const mesh_tools::Mesh* frame : {&mesh.previous(), &mesh.current()}) {
      for (const Vec3d& x : frame->positions) scene.include(x);
    }
  }
  const Vec3d extent = scene.hi - scene.lo;
  return 0x1p-20 * std::max({extent.x, extent.y, extent.z}) + 0x1p-140;
}

ProbeBox box_of(const mesh_tools::Mesh& mesh, const Triangle& triangle, double slack) {
  Box box;
  for (const std::uint32_t v : triangle.v) box.include(mesh.positions[v]);
  const Vec3d border{slack, slack, slack};
  return {box.lo - border, box.hi + border};
}

mesh_tools::Face face_of(const mesh_tools::Mesh& mesh, std::uint64_t first_vertex, std::uint32_t triangle) {
  mesh_tools::Face face{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t v = mesh.triangles[triangle].v[i];
    face.v[i] = first_vertex + v;
    face.x[i] = mesh.positions[v];
  }
  return face;
}

bool is_float(const Vec3d& x) {
  return x == vec3_cast<double>(vec3_cast<float>(x));
}

bool are_floats(const std::vector<MeshSequence>& meshes) {
  return std::all_of(meshes.begin(), meshes.end(), [](const MeshSequence& mesh) {
    const auto& positions = mesh.current().positions;
    return std::all_of(positions.begin(), positions.end(), is_float);
  });
}

}  // namespace

std::uint32_t FrameIntersections::mesh_of(BodyId body) const {
  return static_cast<std::uint32_t>(std::find(bodies_.begin(), bodies_.end(), body) - bodies_.begin());
}

void FrameIntersections::visit_intersecting(const Visit& visit) {
  const std::array<ProbeBodies, 2> bodies = {{{bodies_[0], bodies_[0]}, {bodies_[0], BodyId()}}};
  // Most frames have none, and finding that takes half of the time that listing takes.
  if (std::none_of(bodies.begin(), bodies.end(), [&](const ProbeBodies& p) { return probe_.has_intersections(p); })) {
    return;
  }
  for (const TriangleIntersection& found : probe_.intersections(Span<const ProbeBodies>(bodies)).all()) {
    if (found.body_a == bodies_[0]) {
      visit(found.triangle_a, mesh_of(found.body_b), found.triangle_b);
    } else {
      visit(found.triangle_b, mesh_of(found.body_a), found.triangle_a);
    }
  }
}

void FrameIntersections::visit_near(const std::vector<MeshSequence>& meshes, const Visit& visit) {
  const double slack = rounding_of(meshes);
  const mesh_tools::Mesh& mesh = meshes[0].current();
  std::vector<ProbeBox> boxes;
  for (std::size_t begin = 0; begin < mesh.triangles.size(); begin += kTrianglesAtOnce) {
    const std::size_t end = std::min(begin + kTrianglesAtOnce, mesh.triangles.size());
    boxes.clear();
    for (std::size_t t = begin; t < end; ++t) boxes.push_back(box_of(mesh, mesh.triangles[t], slack));
    const AnswerLists<TriangleOverlap> nearby = probe_.overlaps(Span<const ProbeBox>(boxes));
    for (std::size_t t = begin; t < end; ++t) {
      const auto triangle = static_cast<std::uint32_t>(t);
      for (const TriangleOverlap& overlap : nearby[t - begin]) {
        const std::uint32_t other = mesh_of(overlap.body);
        if (other != 0 || overlap.triangle > triangle) visit(triangle, other, overlap.triangle);
      }
    }
  }
}

std::vector<TrianglePair> FrameIntersections::find(const std::vector<MeshSequence>& meshes) {
  std::vector<std::uint64_t> first_vertex = {0};
  for (const MeshSequence& mesh : meshes) {
    first_vertex.push_back(first_vertex.back() + mesh.current().positions.size());
  }
  std::vector<TrianglePair> pairs;
  const Visit add = [&](std::uint32_t triangle_a, std::uint32_t mesh_b, std::uint32_t triangle_b) {
    const mesh_tools::Meeting meeting =
        mesh_tools::meeting_of(face_of(meshes[0].current(), 0, triangle_a),
                               face_of(meshes[mesh_b].current(), first_vertex[mesh_b], triangle_b));
    if (meeting != mesh_tools::Meeting::apart) {
      pairs.push_back({triangle_a, mesh_b, triangle_b, meeting == mesh_tools::Meeting::through});
    }
  };
  if (are_floats(meshes)) {
    visit_intersecting(add);
  } else {
    visit_near(meshes, add);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace softcd::demo

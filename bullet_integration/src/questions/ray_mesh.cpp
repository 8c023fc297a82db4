#include "questions/ray_mesh.hpp"

#include <bit>
#include <cmath>
#include <type_traits>

#include "softcd/mesh/given_positions.hpp"
#include "softcd/stages/ray_casting.hpp"

namespace softcd::bullet {
namespace {

constexpr int kTetrahedronSides[4][3] = {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 2, 3}};

Vec3<btScalar> vec3_of(const btVector3& x) {
  return {x.x(), x.y(), x.z()};
}

/// Compares bytes, so that a value that is not a number equals itself.
bool are_same(const Vec3<btScalar>& a, const btVector3& b) {
  using Bits = std::array<std::conditional_t<sizeof(btScalar) == 8, std::uint64_t, std::uint32_t>, 3>;
  return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(vec3_of(b));
}

}  // namespace

std::size_t RayMesh::triangle_count(const btSoftBody& body) const {
  const int tetrahedra = targets_ == RayTargets::faces_and_tetrahedra ? body.m_tetras.size() : 0;
  return static_cast<std::size_t>(body.m_faces.size()) + 4 * static_cast<std::size_t>(tetrahedra);
}

RayMesh::Corners RayMesh::corners(const btSoftBody& body, std::size_t triangle) const {
  const auto faces = static_cast<std::size_t>(body.m_faces.size());
  if (triangle < faces) {
    const auto& nodes = body.m_faces[static_cast<int>(triangle)].m_n;
    return {nodes[0], nodes[1], nodes[2]};
  }
  const auto& nodes = body.m_tetras[static_cast<int>((triangle - faces) / 4)].m_n;
  const auto& side = kTetrahedronSides[(triangle - faces) % 4];
  return {nodes[side[0]], nodes[side[1]], nodes[side[2]]};
}

bool RayMesh::seems_up_to_date(const btSoftBody& body) const {
  return triangle_count(body) == corners_.size() && static_cast<std::uint32_t>(body.m_faces.size()) == face_count_ &&
         static_cast<std::size_t>(body.m_nodes.size()) == positions_.size() &&
         (positions_.empty() || &body.m_nodes[0] == first_node_) && are_same(bounds_[0], body.m_bounds[0]) &&
         are_same(bounds_[1], body.m_bounds[1]);
}

bool RayMesh::is_up_to_date(const btSoftBody& body, std::uint32_t triangle) const {
  if (corners(body, triangle) != corners_[triangle]) return false;
  for (const std::uint32_t node : triangles_[triangle].v) {
    if (!are_same(positions_[node], body.m_nodes[static_cast<int>(node)].m_x)) return false;
  }
  return true;
}

bool RayMesh::has_same_corners(const btSoftBody& body) const {
  if (triangle_count(body) != corners_.size() || static_cast<std::uint32_t>(body.m_faces.size()) != face_count_ ||
      static_cast<std::size_t>(body.m_nodes.size()) != positions_.size() ||
      (!positions_.empty() && &body.m_nodes[0] != first_node_)) {
    return false;
  }
  for (std::size_t t = 0; t < corners_.size(); ++t) {
    if (corners(body, t) != corners_[t]) return false;
  }
  return true;
}

bool RayMesh::has_same_positions(const btSoftBody& body) const {
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (!are_same(positions_[i], body.m_nodes[static_cast<int>(i)].m_x)) return false;
  }
  return true;
}

void RayMesh::update(const btSoftBody& body) {
  if (!has_same_corners(body)) read_triangles(body);
  if (!has_bvh_ || !has_same_positions(body)) read_positions(body);
  for (int i = 0; i < 2; ++i) bounds_[i] = vec3_of(body.m_bounds[i]);
}

void RayMesh::read_triangles(const btSoftBody& body) {
  has_bvh_ = false;
  const auto node_count = static_cast<std::size_t>(body.m_nodes.size());
  const std::size_t count = triangle_count(body);
  face_count_ = static_cast<std::uint32_t>(body.m_faces.size());
  first_node_ = node_count > 0 ? &body.m_nodes[0] : nullptr;
  positions_.resize(node_count);
  x_.resize(node_count);
  corners_.resize(count);
  triangles_.resize(count);
  ownership_.resize(count);
  triangle_body_.assign(count, 0);
  for (std::size_t t = 0; t < count; ++t) {
    corners_[t] = corners(body, t);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto node = static_cast<std::size_t>(corners_[t][i] - first_node_);
      if (node >= node_count) throw InvalidInput("a face or tetrahedron has a node that its soft body does not have.");
      triangles_[t].v[i] = static_cast<std::uint32_t>(node);
    }
  }
}

void RayMesh::read_positions(const btSoftBody& body) {
  if (corners_.empty()) return;
  const auto node = [&](std::size_t i) { return vec3_of(body.m_nodes[static_cast<int>(i)].m_x); };
  // Positions in float need no origin.
  if (std::is_same_v<btScalar, double>) origin_ = vec3_cast<double>(node(triangles_[0].v[0]));
  if (!is_usable(origin_)) origin_ = {0, 0, 0};
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    positions_[i] = node(i);
    x_[i] = placed(vec3_cast<double>(positions_[i]), origin_);
  }
  Box bounds = empty_box();
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& v = triangles_[t].v;
    const Vec3f x[3] = {x_[v[0]], x_[v[1]], x_[v[2]]};
    const bool is_finite = !std::isnan(x[0].x) && !std::isnan(x[1].x) && !std::isnan(x[2].x);
    ownership_[t] = is_finite ? Ownership{0} : static_cast<Ownership>(kLeftOut);
    if (is_finite) bounds = merged(bounds, box_of(x));
  }
  const BvhInput input = {x_.data(),
                          triangles_.data(),
                          ownership_.data(),
                          triangle_body_.data(),
                          static_cast<std::uint32_t>(triangles_.size()),
                          bounds};
  if (has_bvh_) {
    bvh_.follow(input);
  } else {
    bvh_.build(input);
  }
  has_bvh_ = true;
}

RayHit RayMesh::first_hit(const Ray& ray) const {
  RayHit hit;
  if (!has_bvh_) return hit;
  ProbedBody body{};
  body.is_asked = true;
  const Box bounds = bvh_.bounds();
  const Vec3d lo = vec3_cast<double>(bounds.lo);
  const Vec3d hi = vec3_cast<double>(bounds.hi);
  ProbedSceneView scene{};
  scene.bvh = bvh_.view();
  scene.bodies = &body;
  scene.origin = origin_;
  scene.centre = 0.5 * (lo + hi);
  scene.extent = 0.5 * max_norm(hi - lo);
  FindFirstHit{scene, &ray, &hit}(0);
  return hit;
}

}  // namespace softcd::bullet

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/mesh/features.hpp"
#include "softcd/pipeline/serial_bvh.hpp"
#include "softcd/softcd.hpp"
#include "softcd/stages/probed_scene.hpp"

namespace softcd::bullet {

/// The elements of a soft body that a world's ray tests in Bullet hit.
enum class RayTargets : bool { faces, faces_and_tetrahedra };

/// A soft body's triangles when it was last read, and the hierarchy that rays search. Triangles are the faces and,
/// after them, the four sides of each tetrahedron.
class RayMesh {
 public:
  explicit RayMesh(RayTargets targets) : targets_(targets) {}

  /// Reads the body if it has changed. Throws InvalidInput if a triangle has a node that is not the body's.
  void update(const btSoftBody& body);
  /// Compares every node and triangle.
  bool is_up_to_date(const btSoftBody& body) const { return has_same_corners(body) && has_same_positions(body); }
  /// Compares sizes and bounds, in constant time. Bullet's own functions change these when they move the body as a
  /// whole, and when they add or remove nodes and triangles.
  bool seems_up_to_date(const btSoftBody& body) const;
  /// Compares one triangle.
  bool is_up_to_date(const btSoftBody& body, std::uint32_t triangle) const;

  /// Returns the first triangle that the ray hits. The hit's body has no meaning.
  RayHit first_hit(const Ray& ray) const;
  std::uint32_t face_count() const { return face_count_; }

 private:
  using Node = btSoftBody::Node;
  using Corners = std::array<const Node*, 3>;

  std::size_t triangle_count(const btSoftBody& body) const;
  Corners corners(const btSoftBody& body, std::size_t triangle) const;
  bool has_same_corners(const btSoftBody& body) const;
  bool has_same_positions(const btSoftBody& body) const;
  void read_triangles(const btSoftBody& body);
  void read_positions(const btSoftBody& body);

  RayTargets targets_;
  std::uint32_t face_count_ = 0;
  const Node* first_node_ = nullptr;  ///< address of the first node when the body was read
  std::vector<Vec3<btScalar>> positions_;
  Vec3<btScalar> bounds_[2] = {};
  std::vector<Corners> corners_;
  std::vector<Triangle> triangles_;
  std::vector<Ownership> ownership_;
  std::vector<std::uint32_t> triangle_body_;
  Vec3d origin_{0, 0, 0};
  std::vector<Vec3f> x_;  ///< relative to the origin
  SerialBvh bvh_;
  bool has_bvh_ = false;  ///< of these triangles
};

}  // namespace softcd::bullet

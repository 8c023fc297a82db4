#pragma once

#include <cfloat>
#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/spatial_query.hpp"
#include "softcd/math/intersection.hpp"
#include "softcd/mesh/given_positions.hpp"
#include "softcd/stages/answer_lists.hpp"
#include "softcd/stages/probed_scene.hpp"

namespace softcd {

/// Marks a vertex that a change would add. The scene has fewer vertices than this.
constexpr std::uint32_t kNewVertex = 0x80000000u;

/// A change of a mesh that might be made; see ProbeChange. The triangles that it would add are the items of stages.
struct ChangeQuestion {
  std::uint32_t body;  ///< its number in the scene
  std::uint32_t removed_begin, removed_end;
  std::uint64_t first_item, end_item;
};

/// All changes. Triangles and vertices are the scene's; new vertex i is kNewVertex | i.
struct ChangeQuestions {
  Span<const ChangeQuestion> changes;
  Span<const std::uint32_t> removed;  ///< ascending within each change
  Span<const Triangle> added;
  Span<const Vec3d> new_vertices;  ///< in world coordinates
};

/// A triangle that a change would add, with its positions.
struct AddedTriangle {
  Triangle vertices;
  Vec3f x[3];

  SOFTCD_HD bool is_finite() const {
    for (const Vec3f& p : x) {
      if (!(magnitude(p.x) <= FLT_MAX && magnitude(p.y) <= FLT_MAX && magnitude(p.z) <= FLT_MAX)) return false;
    }
    return true;
  }
};

/// The changes in the backend's memory.
struct AskedChanges {
  ProbedSceneView scene;
  ChangeQuestions asked;

  SOFTCD_HD AddedTriangle added(std::uint64_t item) const {
    AddedTriangle triangle{asked.added[item], {}};
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t v = triangle.vertices.v[corner];
      triangle.x[corner] =
          (v & kNewVertex) != 0U ? placed(asked.new_vertices[v & ~kNewVertex], scene.origin) : scene.x[v];
    }
    return triangle;
  }

  SOFTCD_HD bool is_removed(const ChangeQuestion& change, std::uint32_t triangle) const {
    std::uint32_t first = change.removed_begin;
    std::uint32_t last = change.removed_end;
    while (first < last) {
      const std::uint32_t middle = first + (last - first) / 2;
      if (asked.removed[middle] < triangle) {
        first = middle + 1;
      } else {
        last = middle;
      }
    }
    return first < change.removed_end && asked.removed[first] == triangle;
  }
};

/// Finds the triangles of the scene that one added triangle would intersect, except removed ones.
template <class Sink>
class ChangeVisitor {
 public:
  using Key = bool;

  SOFTCD_HD ChangeVisitor(const AskedChanges& asked, const ChangeQuestion& change, std::uint32_t item,
                          const AddedTriangle& own, Sink& sink)
      : asked_(asked), change_(change), item_(item), own_(own), box_(box_of(own.x)), sink_(sink) {}

  SOFTCD_HD bool enters(const Box& box, bool& key) const {
    key = true;
    return overlap(box, box_);
  }
  SOFTCD_HD bool still_enters(bool /*key*/) const { return true; }
  SOFTCD_HD void visit(const BvhLeaf& other, std::uint32_t /*place*/) {
    if (!asked_.scene.is_asked(other) || !overlap(box_, box_of(other.x))) return;
    SharedCorners shared;
    if (other.body == change_.body) {
      if (asked_.is_removed(change_, other.triangle)) return;
      shared = shared_corners(own_.vertices, asked_.scene.triangles[other.triangle]);
    }
    if (!do_intersect(own_.x, other.x, shared)) return;
    const ProbedBody& body = asked_.scene.bodies[other.body];
    sink_.add([&] { return ChangeIntersection{index(), {body.id}, other.triangle - body.first_triangle}; });
  }

  /// Finds the added triangles that it would intersect, each pair once.
  SOFTCD_HD void visit_added() {
    for (std::uint64_t j = item_ + 1ULL; j < change_.end_item; ++j) {
      const AddedTriangle other = asked_.added(j);
      if (!other.is_finite() || !overlap(box_, box_of(other.x))) continue;
      if (!do_intersect(own_.x, other.x, shared_corners(own_.vertices, other.vertices))) continue;
      sink_.add([&] {
        return ChangeIntersection{index(), BodyId(), static_cast<std::uint32_t>(j - change_.first_item)};
      });
    }
  }

 private:
  SOFTCD_HD std::uint32_t index() const { return static_cast<std::uint32_t>(item_ - change_.first_item); }

  const AskedChanges& asked_;
  const ChangeQuestion& change_;
  std::uint32_t item_;
  const AddedTriangle& own_;
  Box box_;
  Sink& sink_;
};

/// Lists the intersections of each added triangle.
struct ListChangeIntersections {
  using Answer = ChangeIntersection;

  AskedChanges asked;

  template <class Sink>
  SOFTCD_HD void list(std::uint32_t item, Sink& sink) const {
    const Span<const ChangeQuestion> changes = asked.asked.changes;
    const ChangeQuestion& change =
        changes[question_of(changes.data(), static_cast<std::uint32_t>(changes.size()), item)];
    const AddedTriangle own = asked.added(item);
    if (!own.is_finite()) return;
    ChangeVisitor<Sink> visitor(asked, change, item, own, sink);
    visit_leaves(asked.scene.bvh, visitor);
    visitor.visit_added();
  }

  /// Intersections with added triangles have no body, and come last.
  static SOFTCD_HD bool is_before(const ChangeIntersection& a, const ChangeIntersection& b) {
    return a.body.value != b.body.value ? a.body.value < b.body.value : a.triangle < b.triangle;
  }
};

}  // namespace softcd

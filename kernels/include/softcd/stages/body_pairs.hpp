#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/spatial_query.hpp"
#include "softcd/math/intersection.hpp"
#include "softcd/stages/answer_lists.hpp"
#include "softcd/stages/probed_scene.hpp"
#include "softcd/stages/shared_least.hpp"

namespace softcd {

/// A question about pairs of bodies; see ProbeBodies. Bodies are numbers in the scene, kNoIndex for all. Each triangle
/// of `a` is an item of the stages. The items of one question are behind those of the one before.
struct BodiesQuestion {
  std::uint32_t a, b;
  std::uint32_t first_triangle;  ///< of the scene, for the first item
  std::uint64_t first_item;
  BodyClasses partners;           ///< the classes of `b`
  BodyClasses repeated_partners;  ///< of these, the classes in which a triangle's own body has another one
};

/// All questions.
struct BodiesQuestions {
  ProbedSceneView scene;
  const BodiesQuestion* questions;
  std::uint32_t count;

  SOFTCD_HD std::uint32_t question_of(std::uint32_t item) const { return softcd::question_of(questions, count, item); }

  /// Returns the item's triangle; none if the question leaves it out.
  SOFTCD_HD BvhLeaf triangle_of(std::uint32_t item, const BodiesQuestion& question) const {
    return scene.asked_leaf(question.first_triangle + static_cast<std::uint32_t>(item - question.first_item));
  }
};

/// Returns the classes of bodies other than the triangle's own that the question is about.
SOFTCD_HD inline BodyClasses other_bodies(const BodiesQuestion& question, const BvhLeaf& own) {
  return static_cast<BodyClasses>((question.partners & ~class_of(own.body)) | question.repeated_partners);
}

/// Whether the question is about these two triangles, in this order. A pair counts in one order only.
SOFTCD_HD inline bool are_asked_together(const BodiesQuestion& question, const BvhLeaf& own, const BvhLeaf& other) {
  if (question.b != kNoIndex && other.body != question.b) return false;
  if (question.a == question.b) return own.triangle < other.triangle;
  return own.body != other.body;
}

/// Returns whether two triangles intersect, by their given positions.
SOFTCD_HD_LONG inline bool do_intersect_as_given(const ProbedSceneView& scene, const BvhLeaf& a, const BvhLeaf& b,
                                                 const SharedCorners& shared) {
  Vec3d x_a[3];
  Vec3d x_b[3];
  for (int corner = 0; corner < 3; ++corner) {
    x_a[corner] = scene.full[scene.triangles[a.triangle].v[corner]];
    x_b[corner] = scene.full[scene.triangles[b.triangle].v[corner]];
  }
  return do_intersect(x_a, x_b, shared);
}

/// Finds triangles that one intersects, as far as the question is about them. Calls found(own, other) until it returns
/// false. Boxes of floats suffice to reject triangles, even if given positions decide: the rounding of a coordinate
/// is monotonic (see placed), so boxes that overlap still overlap or touch when their coordinates are rounded.
template <class Found>
class IntersectionVisitor {
 public:
  using Key = bool;

  SOFTCD_HD IntersectionVisitor(const ProbedSceneView& scene, const BodiesQuestion& question, const BvhLeaf& own,
                                Found& found)
      : scene_(scene), question_(question), own_(own), box_(box_of(own.x)), found_(found) {}

  SOFTCD_HD bool enters(const Box& box, bool& key) const {
    key = true;
    return goes_on_ && overlap(box, box_);
  }
  SOFTCD_HD bool still_enters(bool /*key*/) const { return goes_on_; }
  SOFTCD_HD void visit(const BvhLeaf& other, std::uint32_t /*place*/) {
    if (!scene_.is_asked(other) || !are_asked_together(question_, own_, other)) return;
    if (!overlap(box_, box_of(other.x))) return;
    SharedCorners shared;
    if (own_.body == other.body) {
      shared = shared_corners(scene_.triangles[own_.triangle], scene_.triangles[other.triangle]);
    }
    const bool are_found = scene_.full != nullptr ? do_intersect_as_given(scene_, own_, other, shared)
                                                  : do_intersect(own_.x, other.x, shared);
    if (are_found) goes_on_ = found_(own_, other);
  }

 private:
  const ProbedSceneView& scene_;
  const BodiesQuestion& question_;
  const BvhLeaf& own_;
  Box box_;
  Found& found_;
  bool goes_on_ = true;
};

template <class Found>
SOFTCD_HD void visit_intersections(const BodiesQuestions& asked, std::uint32_t item, Found& found) {
  const BodiesQuestion& question = asked.questions[asked.question_of(item)];
  const BvhLeaf own = asked.triangle_of(item, question);
  if (own.triangle == kNoIndex) return;
  const BodyClasses bodies = question.a == question.b ? question.partners : other_bodies(question, own);
  IntersectionVisitor<Found> visitor(asked.scene, question, own, found);
  visit_leaves(asked.scene.bvh, visitor, bodies);
}

/// Lists pairs of intersecting triangles for each item.
struct ListIntersections {
  using Answer = TriangleIntersection;

  BodiesQuestions asked;

  template <class Sink>
  SOFTCD_HD void list(std::uint32_t item, Sink& sink) const {
    AddTo<Sink> found{asked.scene, sink};
    visit_intersections(asked, item, found);
  }

  static SOFTCD_HD bool is_before(const TriangleIntersection& a, const TriangleIntersection& b) {
    return a.body_b.value != b.body_b.value ? a.body_b.value < b.body_b.value : a.triangle_b < b.triangle_b;
  }

 private:
  template <class Sink>
  struct AddTo {
    const ProbedSceneView& scene;
    Sink& sink;

    SOFTCD_HD bool operator()(const BvhLeaf& own, const BvhLeaf& other) {
      sink.add([&] {
        const ProbedBody& a = scene.bodies[own.body];
        const ProbedBody& b = scene.bodies[other.body];
        return TriangleIntersection{{a.id}, own.triangle - a.first_triangle, {b.id}, other.triangle - b.first_triangle};
      });
      return true;
    }
  };
};

/// Sets a word to 0 if triangles intersect, and then skips the remaining items.
struct FindIntersection {
  BodiesQuestions asked;
  std::uint64_t* least;

  SOFTCD_HD void operator()(std::uint32_t item) const {
    if (load(least) == 0) return;
    Note note{least};
    visit_intersections(asked, item, note);
  }

 private:
  struct Note {
    std::uint64_t* least;

    SOFTCD_HD bool operator()(const BvhLeaf& /*own*/, const BvhLeaf& /*other*/) {
      lower(least, 0);
      return false;
    }
  };
};

}  // namespace softcd

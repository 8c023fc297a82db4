#pragma once

#include <cstdint>
#include <type_traits>

#include "softcd/core/contact.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/impact/impact.hpp"
#include "softcd/mesh/scene_view.hpp"

namespace softcd {

/// A contact between features by their scene-wide indices.
struct alignas(16) FeatureContact {
  std::uint64_t
      features;  ///< kind:1 | vertex:31 | triangle:32, or kind:1 | lower edge:31 | higher edge:32, from high to low
  float weights[4];
  Vec3f normal;
  float distance;
  float time;
  std::uint32_t is_unsettled;  ///< see ImpactState
};

SOFTCD_HD constexpr std::uint64_t with_kind(ContactKind kind, std::uint64_t candidate) {
  return (static_cast<std::uint64_t>(kind) << 63) | candidate;
}
SOFTCD_HD constexpr ContactKind kind_of(std::uint64_t features) {
  return static_cast<ContactKind>(features >> 63);
}
SOFTCD_HD constexpr std::uint32_t first_feature(std::uint64_t features) {
  return static_cast<std::uint32_t>(features >> 32) & 0x7FFFFFFFU;
}
SOFTCD_HD constexpr std::uint32_t second_feature(std::uint64_t features) {
  return static_cast<std::uint32_t>(features);
}

/// The four vertices of a candidate, in the order of Contact::vertices.
struct FeatureVertices {
  std::uint32_t v[4];
};

template <ContactKind kKind>
SOFTCD_HD FeatureVertices feature_vertices(const SceneView& scene, std::uint64_t features) {
  const std::uint32_t a = first_feature(features);
  const std::uint32_t b = second_feature(features);
  if constexpr (kKind == ContactKind::vertex_triangle) {
    const Triangle t = scene.triangles[b];
    return {{a, t.v[0], t.v[1], t.v[2]}};
  } else {
    const Edge e = scene.edges[a];
    const Edge g = scene.edges[b];
    return {{e.v[0], e.v[1], g.v[0], g.v[1]}};
  }
}

/// The distance up to which the candidate's features are in contact: the sum of both sides' margins. In float it is
/// rounded once; outward_up of it is no less than in exact arithmetic.
template <ContactKind kKind, class T>
SOFTCD_HD T contact_margin(const SceneView& scene, const FeatureVertices& vertices) {
  const std::uint32_t body_a = scene.vertex_body[vertices.v[0]];
  const std::uint32_t body_b = scene.vertex_body[vertices.v[kKind == ContactKind::vertex_triangle ? 1 : 2]];
  const bool counts_motion = kKind == ContactKind::vertex_triangle && body_a != body_b;
  const T margin_a =
      counts_motion ? scene.vertex_margin<T>(vertices.v[0]) : static_cast<T>(scene.bodies[body_a].margin);
  return margin_a + static_cast<T>(scene.bodies[body_b].margin);
}

/// Whether one side lies beyond the other along x, y or z at both ends of a straight-line motion, and so throughout.
/// Exact. Candidates' floats have been compared like that, but positions in double only with a tolerance for their
/// rounding.
template <ContactKind kKind>
SOFTCD_HD bool are_apart_along_an_axis(const Vec3d (&t0)[4], const Vec3d (&t1)[4]) {
  constexpr int kSplit = kKind == ContactKind::vertex_triangle ? 1 : 2;
  const auto are_apart_along = [&](int axis) {
    bool is_below = true;
    bool is_above = true;
    for (int a = 0; a < kSplit; ++a) {
      for (int b = kSplit; b < 4; ++b) {
        is_below = is_below && t0[a][axis] < t0[b][axis] && t1[a][axis] < t1[b][axis];
        is_above = is_above && t0[a][axis] > t0[b][axis] && t1[a][axis] > t1[b][axis];
      }
    }
    return is_below || is_above;
  };
  return are_apart_along(0) || are_apart_along(1) || are_apart_along(2);
}

/// Keeps the candidates that are within their margin at t1 (the paper's narrow phase for DCD), computed in T.
template <ContactKind kKind, class T>
struct TestProximity {
  SceneView scene;
  const std::uint64_t* candidates;

  template <class Contacts>
  SOFTCD_HD void operator()(std::uint32_t i, Contacts& contacts) const {
    const FeatureVertices vertices = feature_vertices<kKind>(scene, candidates[i]);
    Vec3<T> x[4];
    for (int corner = 0; corner < 4; ++corner) x[corner] = scene.position_t1<T>(vertices.v[corner]);
    T margin = contact_margin<kKind, T>(scene, vertices);
    if constexpr (std::is_same_v<T, double>) {
      if (scene.full_t1 != nullptr && !(margin > T(0)) && are_apart_along_an_axis<kKind>(x, x)) return;
    }
    if (scene.is_conservative) margin += distance_tolerance<kKind>(x);
    const ClosestPoints<T> closest = closest_points(x);
    if (!closest.are_within(margin)) return;

    const bool is_apart = max_norm(closest.offset) > T(0);
    const Vec3<T> normal = is_apart ? unit_vector(closest.offset) : touching_normal(x, closest.scale);
    FeatureContact contact{with_kind(kKind, candidates[i]),        {},   vec3_cast<float>(normal),
                           static_cast<float>(closest.distance()), 1.0F, 0U};
    for (int corner = 0; corner < 4; ++corner) contact.weights[corner] = static_cast<float>(closest.weights[corner]);
    contacts.push(contact);
  }

 private:
  static SOFTCD_HD ClosestPoints<T> closest_points(const Vec3<T> (&x)[4]) {
    if constexpr (kKind == ContactKind::vertex_triangle) {
      return closest_points_vertex_triangle(x[0], x[1], x[2], x[3]);
    } else {
      return closest_points_edge_edge(x[0], x[1], x[2], x[3]);
    }
  }

  /// Unit normal of the plane of features at distance 0; its side is arbitrary.
  static SOFTCD_HD Vec3<T> touching_normal(const Vec3<T> (&x)[4], T scale) {
    const detail::RelativePair<T> pair = detail::scaled(scale, detail::relative_pair<kKind>(x));
    const Vec3<T> plane = cross(pair.b, pair.c);
    return max_norm(plane) > T(0) ? unit_vector(plane) : Vec3<T>{T(0), T(0), T(1)};
  }
};

/// Covers the roundings of the components of a cross product, and far more of what follows.
constexpr float kSlabCrossError = 32.0F * epsilon<float>();
constexpr float kSlabDifferenceError = 4.0F * epsilon<float>();

/// Returns true only if the vertex of `input` certainly is in no contact with its triangle by ContactRule::slab,
/// because it is out of the slab's box. Cheap. The slab reaches d times the triangle's own extent beyond it along every
/// axis, and the margin along the normal.
SOFTCD_HD inline bool certainly_outside_slab(const detail::RelativePair<float>& input, float input_margin) {
  const float extent = detail::extent(input);
  const float scale = safe_scale(extent);
  const detail::RelativePair<float> pair = detail::scaled(scale, input);
  const float margin = scale * input_margin;
  const Vec3f normal = cross(pair.b, pair.c);
  const float product = max_norm(pair.b) * max_norm(pair.c);
  const float error = kSlabCrossError * product;
  const float twice_area = norm(normal) - error;
  if (!(twice_area > 0.0F && product >= detail::smallest_product<float>())) return false;
  const float slack = margin * sqrtf(2.0F / twice_area);
  const float rounding = kSlabDifferenceError * (scale * extent);
  bool is_outside = false;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = smaller(0.0F, smaller(pair.b[axis], pair.c[axis]));
    const float high = larger(0.0F, larger(pair.b[axis], pair.c[axis]));
    const float along_normal = margin * ((magnitude(normal[axis]) + error) / twice_area);
    const float beyond = 1.0001F * (slack * (high - low) + along_normal) + rounding;
    is_outside |= pair.a[axis] - high > beyond || low - pair.a[axis] > beyond;
  }
  return is_outside;
}

/// Keeps the vertex-triangle candidates that ContactRule::slab calls contacts. The normal is the triangle's, on the
/// vertex's side, and the distance the one from its plane; the weights may leave [0, 1]. Computed in T.
template <class T>
struct TestSlab {
  SceneView scene;
  const std::uint64_t* candidates;

  template <class Contacts>
  SOFTCD_HD void operator()(std::uint32_t i, Contacts& contacts) const {
    constexpr ContactKind kKind = ContactKind::vertex_triangle;
    const FeatureVertices vertices = feature_vertices<kKind>(scene, candidates[i]);
    Vec3<T> x[4];
    for (int corner = 0; corner < 4; ++corner) x[corner] = scene.position_t1<T>(vertices.v[corner]);
    detail::RelativePair<T> pair = detail::relative_pair<kKind>(x);
    const T scale = safe_scale(detail::extent(pair));
    pair = detail::scaled(scale, pair);
    const T margin = scale * contact_margin<kKind, T>(scene, vertices);

    const Vec3<T> across = cross(pair.b, pair.c);
    const T twice_area = length(across);
    if (!(twice_area > T(0))) {
      TestProximity<kKind, T>{scene, candidates}(i, contacts);
      return;
    }
    const T height = dot(pair.a, across) / twice_area;
    if (!(magnitude(height) <= margin)) return;
    const detail::Nearest<T> foot = detail::nearest_in_plane(pair);
    const T weights[3] = {(T(1) - foot.x) - foot.y, foot.x, foot.y};
    const T slack = margin / square_root(T(0.5) * twice_area);
    for (const T weight : weights) {
      if (!(weight >= -slack && weight <= T(1) + slack)) return;
    }
    if (!detail::is_vertex_near_triangle(pair, foot, T(5) * margin * margin)) return;

    const T towards = (height < T(0) ? T(-1) : T(1)) / twice_area;
    FeatureContact contact{with_kind(kKind, candidates[i]),
                           {1.0F, 0.0F, 0.0F, 0.0F},
                           vec3_cast<float>(towards * across),
                           static_cast<float>(magnitude(height) / scale),
                           1.0F,
                           0U};
    for (int corner = 0; corner < 3; ++corner) contact.weights[corner + 1] = static_cast<float>(weights[corner]);
    contacts.push(contact);
  }
};

/// A candidate's corners at both ends of the step.
template <class T>
struct CandidateMotion {
  Vec3<T> t0[4], t1[4];

  SOFTCD_HD CandidateMotion(const SceneView& scene, const FeatureVertices& vertices) {
    for (int corner = 0; corner < 4; ++corner) {
      t0[corner] = scene.position_t0<T>(vertices.v[corner]);
      t1[corner] = scene.position_t1<T>(vertices.v[corner]);
    }
  }
};

/// Makes a contact of an impact. Rounds its time towards t0.
template <ContactKind kKind, class T>
SOFTCD_HD FeatureContact contact_of(std::uint64_t candidate, const Impact<T>& impact) {
  FeatureContact contact{with_kind(kKind, candidate),     {},
                         vec3_cast<float>(impact.normal), static_cast<float>(impact.distance),
                         rounded_down(impact.time),       impact.state == ImpactState::unsettled ? 1U : 0U};
  for (int corner = 0; corner < 4; ++corner) contact.weights[corner] = static_cast<float>(impact.weights[corner]);
  return contact;
}

/// Keeps the candidates that come into contact between t0 and t1 by first_coplanar_impact.
template <ContactKind kKind, class T>
struct TestMotion {
  SceneView scene;
  const std::uint64_t* candidates;

  template <class Contacts>
  SOFTCD_HD void operator()(std::uint32_t i, Contacts& contacts) const {
    const FeatureVertices vertices = feature_vertices<kKind>(scene, candidates[i]);
    const CandidateMotion<T> motion(scene, vertices);
    const Impact<T> impact =
        first_coplanar_impact<kKind>(motion.t0, motion.t1, contact_margin<kKind, T>(scene, vertices));
    if (impact.state != ImpactState::separated) contacts.push(contact_of<kKind>(candidates[i], impact));
  }
};

/// Keeps the candidates that come into contact by first_approach, as a search. A backend calls begin(), and unless that
/// returns true, advance() until it does and then finish().
template <ContactKind kKind>
struct TestApproach {
  SceneView scene;
  const std::uint64_t* candidates;

  struct Search {
    std::uint64_t candidate;
    Approach<kKind, double> approach;
  };

  /// Starts a search. Returns true if nothing is left to do.
  template <class Contacts>
  SOFTCD_HD bool begin(std::uint32_t i, Search& search, Contacts& contacts) const {
    search.candidate = candidates[i];
    const FeatureVertices vertices = feature_vertices<kKind>(scene, search.candidate);
    const CandidateMotion<double> motion(scene, vertices);
    const double margin = contact_margin<kKind, double>(scene, vertices);
    if (margin > 0.0) return search.approach.begin(motion.t0, motion.t1, margin);
    if (scene.full_t1 != nullptr && are_apart_along_an_axis<kKind>(motion.t0, motion.t1)) return true;
    const Impact<double> impact = first_approach<kKind>(motion.t0, motion.t1, margin);
    if (impact.state != ImpactState::separated) contacts.push(contact_of<kKind>(search.candidate, impact));
    return true;
  }
  SOFTCD_HD bool advance(Search& search) const { return search.approach.advance(); }
  template <class Contacts>
  SOFTCD_HD void finish(const Search& search, Contacts& contacts) const {
    if (search.approach.is_hit()) contacts.push(contact_of<kKind>(search.candidate, search.approach.impact()));
  }
};

/// Counts the contacts that are reported because they could not be decided.
struct CountUnsettled {
  const FeatureContact* contacts;

  template <class Counter>
  SOFTCD_HD void operator()(std::uint32_t i, Counter& counter) const {
    if (contacts[i].is_unsettled != 0U) counter.push(0U);
  }
};

}  // namespace softcd

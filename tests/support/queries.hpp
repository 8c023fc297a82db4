#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "exact_ccd.hpp"
#include "random.hpp"
#include "softcd/core/types.hpp"
#include "softcd/math/impact/impact.hpp"

namespace softcd::test {

/// Eight rows: v, f0, f1, f2 or e0, e1, g0, g1 at t = 0, then at t = 1.
using Rows = std::array<Vec3d, 8>;

struct Query {
  ContactKind kind;
  Rows rows;
};

/// Families of queries, each difficult in its own way.
enum class Family : std::uint32_t {
  random,        ///< points anywhere in a cube
  touching,      ///< through one point at one time by construction, up to rounding
  near_grazing,  ///< the same, then one vertex pushed by 1e-16 to 1e-6
  tangential,    ///< touching, where the cubic has a double root
  axis_aligned,  ///< small integer coordinates
  planar,        ///< in one plane all along
  degenerate,    ///< repeated vertices, collinear triangles, parallel edges
  needle,        ///< triangles and edges of aspect up to 1e8
  still,         ///< side b, or both, do not move
};

constexpr std::uint32_t kFamilies = 9;
const char* name_of(Family family);

/// Makes a query with coordinates around 1; rounded to float when `is_single`.
Query make_query(Random& random, ContactKind kind, Family family, bool is_single);

/// Returns the rows times `factor`, a power of two, so that the verdict stays.
Rows scaled(const Rows& rows, double factor);

bool collides(const Query& query);
/// Returns a bracket of the exact time at which the features first touch; none when they do not.
std::optional<TimeBracket> first_contact(const Query& query);

/// The corners at both ends, rounded to T.
template <class T>
struct Corners {
  Vec3<T> t0[4], t1[4];

  explicit Corners(const Query& query) {
    for (std::size_t i = 0; i < 4; ++i) {
      t0[i] = vec3_cast<T>(query.rows[i]);
      t1[i] = vec3_cast<T>(query.rows[i + 4]);
    }
  }
};

template <class T>
Impact<T> impact_of(const Query& query, T margin) {
  const auto [t0, t1] = Corners<T>(query);
  return query.kind == ContactKind::vertex_triangle
             ? first_coplanar_impact<ContactKind::vertex_triangle>(t0, t1, margin)
             : first_coplanar_impact<ContactKind::edge_edge>(t0, t1, margin);
}

inline Impact<double> approach_of(const Query& query, double margin) {
  const auto [t0, t1] = Corners<double>(query);
  return query.kind == ContactKind::vertex_triangle ? first_approach<ContactKind::vertex_triangle>(t0, t1, margin)
                                                    : first_approach<ContactKind::edge_edge>(t0, t1, margin);
}

/// Returns the four points at t, rounded.
std::array<Vec3d, 4> rows_at(const Rows& rows, double t);

/// Returns the exact squared distance of the features.
double squared_distance(ContactKind kind, std::span<const Vec3d, 4> rows);

/// Returns 32 epsilon (A + B + C), the documented tolerance.
double documented_tolerance(const Query& query, double epsilon);

/// Returns all coordinates with all figures, for messages.
std::string to_string(const Query& query);

}  // namespace softcd::test
